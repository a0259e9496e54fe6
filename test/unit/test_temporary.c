/*
 * Temporary files: any number of jobs write in one folder, whatever their
 * process ids, and nobody loses a file of a job that lives.
 */
#define _GNU_SOURCE 1 /* renameat2() */
#include "image/rename_new.h"
#include "image/temporary.h"
#include "image/temporary_name.h"
#include "image/temporary_sweep.h"
#include "test/support/folder.h"
#include "test/support/tests.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* Calls that are replaced                                                   */

/* The next numbers that are drawn; 0: the system's. */
static uint64_t drawn[2];
int __real_getentropy(void *out, size_t size);
int __wrap_getentropy(void *out, size_t size);
int __wrap_getentropy(void *out, size_t size) {
  if (!drawn[0])
    return __real_getentropy(out, size);
  memcpy(out, &drawn[0], size);
  drawn[0] = drawn[1];
  drawn[1] = 0;
  return 0;
}

/* What renameat2() and link() fail with; 0: nothing. */
static int no_renameat2, no_link;
#ifdef HBIL_HAS_RENAMEAT2
int __real_renameat2(int a, const char *from, int b, const char *to,
                     unsigned flags);
int __wrap_renameat2(int a, const char *from, int b, const char *to,
                     unsigned flags);
int __wrap_renameat2(int a, const char *from, int b, const char *to,
                     unsigned flags) {
  errno = no_renameat2;
  return no_renameat2 ? -1 : __real_renameat2(a, from, b, to, flags);
}
#endif

static int answer_gets_lost;
int __real_link(const char *from, const char *to);
int __wrap_link(const char *from, const char *to);
int __wrap_link(const char *from, const char *to) {
  if (answer_gets_lost) {
    assert_int_equal(__real_link(from, to), 0);
    errno = EEXIST;
    return -1;
  }
  errno = no_link;
  return no_link ? -1 : __real_link(from, to);
}

/* Which file is removed before it is locked; NULL: none. */
static const char *swept_before_lock;
static int no_locks;
int __real_flock(int fd, int how);
int __wrap_flock(int fd, int how);
int __wrap_flock(int fd, int how) {
  if (swept_before_lock) {
    assert_int_equal(unlink(swept_before_lock), 0);
    swept_before_lock = NULL;
  }
  errno = ENOLCK;
  return no_locks ? -1 : __real_flock(fd, how);
}

/* ------------------------------------------------------------------------ */
/* A folder                                                                  */

static char folder[MOST_PATH];

static int begin(void **state) {
  (void)state;
  folder_make(folder);
  return 0;
}

static int end(void **state) {
  (void)state;
  no_renameat2 = no_link = no_locks = answer_gets_lost = 0;
  drawn[0] = drawn[1] = 0;
  folder_remove(folder);
  return 0;
}

static char *path_in(const char *name) {
  static char paths[4][2 * MOST_PATH];
  static int next;
  char *path = paths[next++ % 4];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  return path;
}

static void write_plain(const char *path, const char *text) {
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  assert_int_equal(fclose(file), 0);
}

static void check_text(const char *path, const char *want) {
  char text[64] = "";
  FILE *file = fopen(path, "r");
  assert_non_null(file);
  text[fread(text, 1, sizeof text - 1, file)] = '\0';
  fclose(file);
  assert_string_equal(text, want);
}

static int is_there(const char *path) {
  struct stat status;
  return lstat(path, &status) == 0;
}

/* A job's file. */
static temporary open_file(const char *path, const char *text) {
  temporary t;
  image_error error = {""};
  if (temporary_open(path, &t, &error) != 0)
    fail_msg("%s", error.text);
  FILE *file = temporary_stream(&t);
  assert_non_null(file);
  fputs(text, file);
  assert_int_equal(fclose(file), 0);
  return t;
}

/* ------------------------------------------------------------------------ */
/* Jobs side by side                                                         */

/* A process has one id, as have two in different containers. */
TEST_WITH(jobs_with_one_process_id_have_files_of_their_own, begin, end) {
  const char *path = path_in("frame.exr");
  temporary a = open_file(path, "the first job's");
  temporary b = open_file(path, "the other's");
  assert_string_not_equal(a.name, b.name);
  assert_int_equal(temporary_commit(&a, path, EXISTING_REPLACED, NULL), 0);
  check_text(path, "the first job's");
  assert_int_equal(temporary_commit(&b, path, EXISTING_REPLACED, NULL), 0);
  check_text(path, "the other's");
  assert_int_equal(folder_count(folder, ""), 1);
}

/* Not even if all numbers are guessed. */
TEST_WITH(links_and_files_of_the_name_are_not_opened, begin, end) {
  const char *victim = path_in("victim");
  const uint64_t numbers[] = {17, 18};
  write_plain(victim, "precious");
  char *name = temporary_name_new(path_in("frame.exr"));
  assert_non_null(name);
  for (int is_file = 0; is_file < 2; ++is_file) {
    drawn[0] = numbers[0];
    temporary_name_draw(name);
    if (is_file)
      write_plain(name, "another job's");
    else
      assert_int_equal(symlink(victim, name), 0);
    memcpy(drawn, numbers, sizeof drawn);
    temporary t = open_file(path_in("frame.exr"), "pixels");
    assert_string_not_equal(t.name, name);
    check_text(victim, "precious");
    temporary_discard(&t);
    check_text(name, is_file ? "another job's" : "precious");
    assert_int_equal(unlink(name), 0);
  }
  free(name);
}

TEST_WITH(names_of_255_bytes_work, begin, end) {
  char name[256];
  memset(name, 'w', sizeof name - 1);
  name[255] = '\0';
  const char *path = path_in(name);
  temporary t = open_file(path, "pixels");
  assert_int_equal(temporary_commit(&t, path, EXISTING_STAYS, NULL), 0);
  check_text(path, "pixels");
}

/* A file that a sweep has found before it was locked, and removed, isn't used.
 */
TEST_WITH(files_without_a_name_are_not_used, begin, end) {
  const char *path = path_in("frame.exr");
  char *name = temporary_name_new(path);
  assert_non_null(name);
  drawn[0] = 17;
  temporary_name_draw(name);
  drawn[0] = 17;
  swept_before_lock = name;
  temporary t = open_file(path, "pixels");
  assert_null(swept_before_lock);
  assert_int_equal(temporary_commit(&t, path, EXISTING_STAYS, NULL), 0);
  check_text(path, "pixels");
  free(name);
}

/* ------------------------------------------------------------------------ */
/* One of two gets a name                                                    */

static void check_one_wins(const char *how) {
  const char *path = path_in("frame.exr");
  image_error error = {""};
  temporary a = open_file(path, "the first job's");
  temporary b = open_file(path, "the other's");
  if (temporary_commit(&a, path, EXISTING_STAYS, &error) != 0)
    fail_msg("%s: %s", how, error.text);
  if (temporary_commit(&b, path, EXISTING_STAYS, &error) == 0)
    fail_msg("%s: both jobs have succeeded", how);
  check_text(path, "the first job's");
  assert_non_null(strstr(error.text, "frame.exr: is there already"));
  assert_null(strchr(error.text, '\n'));
  assert_int_equal(folder_count(folder, ""), 1);
  assert_int_equal(unlink(path), 0);
}

TEST_WITH(one_of_two_jobs_gets_a_name, begin, end) {
  static const int errors[] = {EINVAL, ENOSYS, EPERM, EOPNOTSUPP};
  check_one_wins("rename");
  for (size_t i = 0; i < sizeof errors / sizeof *errors; ++i) {
    no_renameat2 = errors[i];
    no_link = 0;
    check_one_wins("link");
    no_link = errors[i];
    check_one_wins("neither");
  }
}

/* NFS may repeat a call whose answer got lost. */
TEST_WITH(a_link_whose_answer_got_lost_counts, begin, end) {
  const char *path = path_in("frame.exr");
  no_renameat2 = EINVAL;
  answer_gets_lost = 1;
  temporary t = open_file(path, "pixels");
  assert_int_equal(temporary_commit(&t, path, EXISTING_STAYS, NULL), 0);
  check_text(path, "pixels");
  assert_int_equal(folder_count(folder, ""), 1);
}

/* More than a buffer of a stream, so that writing fails before the end, too. */
static void write_bytes(const void *bytes, FILE *out) {
  for (int i = 0; i < *(const int *)bytes; ++i)
    putc('x', out);
}

/* A limit on the size of files stands for a full disk. */
TEST_WITH(what_cannot_be_written_leaves_the_old_file, begin, end) {
  static const int sizes[] = {1100, 100000};
  struct rlimit all, little;
  write_plain(path_in("frame.exr"), "old");
  assert_int_equal(getrlimit(RLIMIT_FSIZE, &all), 0);
  little = all;
  little.rlim_cur = 1024;
  signal(SIGXFSZ, SIG_IGN);
  for (int i = 0; i < 2; ++i) {
    image_error error;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &little), 0);
    const int status = temporary_write(path_in("frame.exr"), EXISTING_REPLACED,
                                       write_bytes, &sizes[i], &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &all), 0);
    assert_int_equal(status, -1);
    assert_non_null(strstr(error.text, "File too large"));
    check_text(path_in("frame.exr"), "old");
    assert_int_equal(folder_count(folder, ""), 1);
    assert_int_equal(temporary_write(path_in("new"), EXISTING_REPLACED,
                                     write_bytes, &sizes[i], &error),
                     0);
    assert_int_equal(unlink(path_in("new")), 0);
  }
}

TEST_WITH(what_cannot_be_renamed_is_removed, begin, end) {
  const char *path = path_in("frame.exr");
  image_error error;
  assert_int_equal(mkdir(path, 0777), 0);
  for (int existing = 0; existing < 2; ++existing) {
    temporary t = open_file(path, "pixels");
    assert_int_equal(
        temporary_commit(&t, path, (existing_file)existing, &error), -1);
    assert_non_null(strstr(error.text, "frame.exr: "));
    assert_int_equal(folder_count(folder, ""), 0);
  }
}

/* ------------------------------------------------------------------------ */
/* What is swept                                                             */

/* A job that is killed while it writes; returns its file. */
static char *killed_job(void) {
  int ends[2];
  char name[2 * MOST_PATH] = "";
  assert_int_equal(pipe(ends), 0);
  const pid_t job = fork();
  if (job == 0) {
    const temporary t = open_file(path_in("frame.exr"), "half of the pixels");
    _exit(write(ends[1], t.name, strlen(t.name)) < 0);
  }
  assert_true(job > 0);
  assert_int_equal(waitpid(job, NULL, 0), job);
  assert_true(read(ends[0], name, sizeof name - 1) > 0);
  close(ends[0]);
  close(ends[1]);
  assert_true(is_there(name));
  return strdup(name);
}

TEST_WITH(files_of_killed_jobs_are_swept, begin, end) {
  char *left = killed_job();
  temporary_sweep(folder);
  assert_false(is_there(left));
  free(left);
}

TEST_WITH(files_of_living_jobs_are_not_swept, begin, end) {
  const char *path = path_in("frame.exr");
  temporary t = open_file(path, "pixels");
  temporary_sweep(folder);
  assert_true(is_there(t.name));
  assert_int_equal(temporary_commit(&t, path, EXISTING_STAYS, NULL), 0);
  check_text(path, "pixels");
}

static void make_old(const char *path) {
  const struct timespec then[2] = {{time(NULL) - 7200, 0},
                                   {time(NULL) - 7200, 0}};
  assert_int_equal(utimensat(AT_FDCWD, path, then, 0), 0);
}

/* Locks of other machines may not show.  Here there may be locks. */
TEST_WITH(files_of_other_machines_are_swept_when_old, begin, end) {
  const char *path = path_in(".hbil-00000000-0123456789abcdef.tmp");
  write_plain(path, "pixels");
  temporary_sweep(folder);
  assert_true(is_there(path));
  make_old(path);
  const int fd = open(path, O_RDWR);
  assert_int_equal(flock(fd, LOCK_EX), 0);
  temporary_sweep(folder);
  assert_true(is_there(path));
  close(fd);
  temporary_sweep(folder);
  assert_false(is_there(path));
}

TEST_WITH(age_decides_where_locks_do_not_work, begin, end) {
  const char *path = path_in("frame.exr");
  no_locks = 1;
  char *left = killed_job();
  temporary t = open_file(path, "pixels");
  temporary_sweep(folder);
  assert_true(is_there(left));
  make_old(left);
  temporary_sweep(folder);
  assert_false(is_there(left));
  assert_int_equal(temporary_commit(&t, path, EXISTING_STAYS, NULL), 0);
  check_text(path, "pixels");
  free(left);
}

TEST_WITH(nothing_else_is_swept, begin, end) {
  static const char *const others[] = {"frame.exr",
                                       "frame.exr.tmp4711",
                                       ".hbil-light.frame",
                                       ".hbil-d791a068-0123456789abcdef.tmp~",
                                       ".hbil-d791a068-0123456789abcdeg.tmp",
                                       ".hbil-.tmp"};
  const int count = sizeof others / sizeof *others;
  for (int i = 0; i < count; ++i) {
    write_plain(path_in(others[i]), "precious");
    make_old(path_in(others[i]));
  }
  /* with a temporary file's name */
  char *name = killed_job();
  assert_int_equal(unlink(name), 0);
  assert_int_equal(symlink(path_in("frame.exr"), name), 0);
  temporary_sweep(folder);
  assert_true(is_there(name));
  assert_int_equal(unlink(name), 0);
  assert_int_equal(mkdir(name, 0777), 0);
  temporary_sweep(folder);
  assert_true(is_there(name));
  assert_int_equal(rmdir(name), 0);
  assert_int_equal(mkfifo(name, 0666), 0);
  temporary_sweep(folder);
  assert_true(is_there(name));
  for (int i = 0; i < count; ++i)
    check_text(path_in(others[i]), "precious");
  temporary_sweep(path_in("no such folder"));
  free(name);
}

int main(void) {
  return tests_run();
}
