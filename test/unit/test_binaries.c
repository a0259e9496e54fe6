/*
 * Stored programs: a later context builds nothing, and what the store has is
 * used only if it is whole and of the same program, device and version.
 */
#define _POSIX_C_SOURCE 200809L /* setenv, symlink */
#include "test/support/fixture.h"
#include "test/support/folder.h"
#include "test/support/room.h"
#include "test/support/shim.h"

#include <dirent.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* ------------------------------------------------------------------------ */
/* A store in memory                                                         */

enum { MOST_ENTRIES = 64 };

typedef struct entry {
  char key[64];
  unsigned char *data;
  size_t size;
} entry;

typedef struct memory {
  entry entries[MOST_ENTRIES];
  int count;
  int loaded, stored; /* by the plan at hand */
  bool mixed_up;      /* gives the data of another key */
  size_t claimed;     /* unless 0: the size that it says */
  int warnings;
} memory;

static entry *find(memory *m, const char *key) {
  for (int i = 0; i < m->count; ++i)
    if (strcmp(m->entries[i].key, key) == 0)
      return &m->entries[i];
  return NULL;
}

static size_t load(void *user, const char *key, void *data, size_t size) {
  memory *m = user;
  const entry *e = find(m, key);
  if (!e)
    return 0;
  if (m->mixed_up)
    e = &m->entries[(e - m->entries + 1) % m->count];
  assert_int_equal(data == NULL, size == 0);
  if (data)
    memcpy(data, e->data, size < e->size ? size : e->size);
  m->loaded += data != NULL;
  return m->claimed ? m->claimed : e->size;
}

static void check_key(const char *key) {
  static const char allowed[] = "abcdefghijklmnopqrstuvwxyz"
                                "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  assert_in_range(strlen(key), 1, 47);
  assert_int_equal(strspn(key, allowed), strlen(key));
}

static void store(void *user, const char *key, const void *data, size_t size) {
  memory *m = user;
  entry *e = find(m, key);
  check_key(key);
  if (!e) {
    assert_in_range(m->count, 0, MOST_ENTRIES - 1);
    e = &m->entries[m->count++];
    snprintf(e->key, sizeof e->key, "%s", key);
  }
  free(e->data);
  e->data = malloc(size);
  assert_non_null(e->data);
  memcpy(e->data, data, size);
  e->size = size;
  m->stored++;
}

static void memory_free(memory *m) {
  for (int i = 0; i < m->count; ++i)
    free(m->entries[i].data);
}

static void hear(hbil_message_kind kind, const char *message, void *user) {
  memory *m = user;
  m->warnings +=
      kind == HBIL_MESSAGE_WARNING && strstr(message, "stored is damaged");
}

/* ------------------------------------------------------------------------ */
/* Plans                                                                     */

/* As few programs as possible. */
static void ao_alone(setup *s) {
  setup_scene(s, SCENE_ROOM, 40, 24, 0);
  setup_no_outputs(s);
  s->config.outputs.ao = one_float;
}

static hbil_context *new_context(memory *m) {
  hbil_context *context = NULL;
  assert_int_equal(
      hbil_context_create(shared_device.context, shared_device.id, &context),
      HBIL_SUCCESS);
  assert_int_equal(hbil_context_set_program_store(context, load, store, m),
                   HBIL_SUCCESS);
  hbil_context_set_callback(context, hear, m);
  return context;
}

static hbil_status make_plan(const hbil_config *config, memory *m) {
  hbil_context *context = new_context(m);
  hbil_plan *plan = NULL;
  m->loaded = m->stored = m->warnings = 0;
  const hbil_status status = hbil_plan_create(context, config, &plan);
  assert_int_equal(plan != NULL, status == HBIL_SUCCESS);
  hbil_plan_destroy(plan);
  hbil_context_destroy(context);
  return status;
}

/* Creates a plan and compares the numbers of programs that were stored and of
 * complaints about the store. */
static void check_plan(const hbil_config *config, memory *m, int stored,
                       int warnings) {
  assert_int_equal(make_plan(config, m), HBIL_SUCCESS);
  assert_int_equal(m->stored, stored);
  assert_int_equal(m->warnings, warnings);
}

static exact_planes run_plan(setup *s, memory *m) {
  device_fixture device = shared_device;
  device.hbil = new_context(m);
  m->loaded = m->stored = m->warnings = 0;
  s->device = &device;
  setup_start_compiled(s);
  for (int i = 0; i < 3; ++i) {
    s->frame.static_frame = i == 2;
    setup_run(s, hbil_enqueue_frame);
  }
  const exact_planes out = outputs_read(s);
  setup_free(s);
  hbil_context_destroy(device.hbil);
  return out;
}

TEST(a_second_context_builds_nothing) {
  memory m = {.count = 0};
  exact_planes out[2];
  for (int i = 0; i < 2; ++i) {
    setup s;
    setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, 40, 24);
    out[i] = run_plan(&s, &m);
    assert_in_range(m.count, 8, MOST_ENTRIES);
    assert_int_equal(m.loaded, i ? m.count : 0);
    assert_int_equal(m.stored, i ? 0 : m.count);
    assert_int_equal(m.warnings, 0);
  }
  assert_int_equal(count_different(&out[0], &out[1]), 0);
  planes_free(&out[0], &out[1]);
  memory_free(&m);
}

TEST(a_second_radiance_cache_builds_nothing) {
  memory m = {.count = 0};
  const hbil_cache_config config = room_cache_config();
  for (int i = 0; i < 2; ++i) {
    hbil_cache *cache = NULL;
    hbil_context *context = new_context(&m);
    m.loaded = m.stored = m.warnings = 0;
    assert_int_equal(hbil_cache_create(context, &config, &cache), HBIL_SUCCESS);
    assert_in_range(m.count, 6, MOST_ENTRIES);
    assert_int_equal(m.loaded, i ? m.count : 0);
    assert_int_equal(m.stored, i ? 0 : m.count);
    assert_int_equal(m.warnings, 0);
    hbil_cache_destroy(cache);
    hbil_context_destroy(context);
  }
  memory_free(&m);
}

/* ------------------------------------------------------------------------ */
/* Plans of one context                                                      */

TEST(plans_share_programs) {
  memory m = {.count = 0};
  exact_planes out[2];
  device_fixture device = shared_device;
  const long held = shim_references();
  shim_share_programs(true);
  device.hbil = new_context(&m);
  for (int i = 0; i < 4; ++i) {
    setup s;
    /* the second plan is a smaller one; with the last, the store is new */
    setup_every_pass(&s, HBIL_REPROJECTION_CAMERA, 0, i == 1 ? 24 : 40, 24);
    s.device = &device;
    if (i == 3)
      assert_int_equal(
          hbil_context_set_program_store(device.hbil, load, store, &m),
          HBIL_SUCCESS);
    m.loaded = m.stored = 0;
    setup_start_compiled(&s);
    setup_run(&s, hbil_enqueue_frame);
    assert_int_equal(m.stored, i ? 0 : m.count);
    assert_int_equal(m.loaded, i == 3 ? m.count : 0);
    if (i % 2 == 0)
      out[i / 2] = outputs_read(&s);
    setup_free(&s);
  }
  assert_int_equal(count_different(&out[0], &out[1]), 0);
  hbil_context_destroy(device.hbil);
  shim_share_programs(false);
  assert_int_equal(shim_references(), held);
  planes_free(&out[0], &out[1]);
  memory_free(&m);
}

/* Any number of kinds of plans, one after the other: no more than 64 programs
 * are held.  There are four kinds of sizes: behind the first four, none is new.
 */
TEST(few_programs_are_held) {
  static const cl_uint sizes[][2] = {{64, 8},      {65, 8},    {1280, 720},
                                     {1281, 720},  {320, 180}, {67, 9},
                                     {1920, 1080}, {999, 999}};
  hbil_context *context = NULL;
  setup s;
  ao_alone(&s);
  shim_share_programs(true);
  shim_skip_builds(true);
  const long held = shim_references();
  assert_int_equal(
      hbil_context_create(shared_device.context, shared_device.id, &context),
      HBIL_SUCCESS);
  const long begun = shim_references();
  long known = 0;
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    hbil_plan *plan = NULL;
    s.config.width = sizes[i][0], s.config.height = sizes[i][1];
    assert_int_equal(hbil_plan_create(context, &s.config, &plan), HBIL_SUCCESS);
    hbil_plan_destroy(plan);
    const long held_now = shim_references() - begun;
    assert_true(i < 4 ? held_now > known : held_now == known);
    known = held_now;
  }
  s.config.width = s.config.height = 24;
  for (cl_uint pitch = 4; pitch <= 256; pitch += 4) {
    hbil_plan *plan = NULL;
    s.config.outputs.ao.pixel_pitch = pitch;
    assert_int_equal(hbil_plan_create(context, &s.config, &plan), HBIL_SUCCESS);
    hbil_plan_destroy(plan);
    assert_in_range(shim_references() - begun, 4, 64);
  }
  assert_int_equal(shim_references() - begun, 64);
  hbil_context_destroy(context);
  assert_int_equal(shim_references(), held);
  shim_skip_builds(false);
  shim_share_programs(false);
  setup_free(&s);
}

/* ------------------------------------------------------------------------ */
/* What must not be used                                                     */

/* A byte of every member of the header, and three of the binary. */
TEST(damaged_bytes_are_found) {
  memory m = {.count = 0};
  setup s;
  ao_alone(&s);
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  for (int region = 0; region < 7; ++region) {
    for (int i = 0; i < m.count; ++i) {
      const size_t size = m.entries[i].size;
      const size_t at[] = {3, 8, 23, 31, 32, 32 + (size - 32) / 2, size - 1};
      m.entries[i].data[at[region]] ^= 1;
    }
    check_plan(&s.config, &m, m.count, m.count);
    check_plan(&s.config, &m, 0, 0);
  }
  setup_free(&s);
  memory_free(&m);
}

/* 0: the entry is empty, which is the same as none. */
TEST(truncated_binaries_are_found) {
  memory m = {.count = 0};
  setup s;
  ao_alone(&s);
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  for (int length = 0; length < 5; ++length) {
    for (int i = 0; i < m.count; ++i) {
      const size_t sizes[] = {0, 1, 32, 33, m.entries[i].size - 1};
      m.entries[i].size = sizes[length];
    }
    check_plan(&s.config, &m, m.count, length ? m.count : 0);
  }
  for (int i = 0; i < m.count; ++i) {
    entry *e = &m.entries[i];
    e->data = realloc(e->data, e->size + 1);
    assert_non_null(e->data);
    e->data[e->size++] = 0;
  }
  check_plan(&s.config, &m, m.count, m.count);
  setup_free(&s);
  memory_free(&m);
}

/* What is too large to be a binary isn't asked for at all. */
TEST(sizes_are_looked_at_first) {
  memory m = {.count = 0};
  setup s;
  ao_alone(&s);
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  m.claimed = 3000000000u;
  check_plan(&s.config, &m, m.count, m.count);
  assert_int_equal(m.loaded, 0);
  setup_free(&s);
  memory_free(&m);
}

TEST(other_programs_are_not_used) {
  memory m = {.count = 0};
  setup s;
  ao_alone(&s);
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  m.mixed_up = true;
  check_plan(&s.config, &m, m.count, m.count);
  setup_free(&s);
  memory_free(&m);
}

/* Another driver, device or setting has other keys. */
TEST(keys_tell_programs_apart) {
  static const cl_device_info what[] = {CL_DEVICE_NAME, CL_DEVICE_VENDOR,
                                        CL_DEVICE_VERSION, CL_DRIVER_VERSION};
  static const char other[] = "OpenCL 1.2 of another kind";
  memory m = {.count = 0};
  setup s;
  ao_alone(&s);
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  const int programs = m.count;
  for (int i = 0; i < 4; ++i) {
    shim_answer(what[i], other, sizeof other);
    check_plan(&s.config, &m, programs, 0);
    assert_int_equal(m.count, programs * (i + 2));
    shim_answer(0, NULL, 0);
  }
  /* only some programs write outputs */
  s.config.outputs.ao.component = HBIL_FLOAT16;
  assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
  assert_in_range(m.stored, 1, programs - 1);
  setup_free(&s);
  memory_free(&m);
}

/* Calls whose failure leaves the store aside. */
static bool is_dispensable(const char *call) {
  return strncmp(call, "clRelease", 9) == 0 ||
         strcmp(call, "clCreateProgramWithBinary") == 0 ||
         strcmp(call, "clGetProgramInfo") == 0 ||
         strcmp(call, "clGetProgramBuildInfo") == 0 ||
         strcmp(call, "clBuildProgram") == 0;
}

/* Each call fails once, while programs are loaded and while they are stored. */
TEST(failures_cost_at_most_the_binary) {
  setup s;
  ao_alone(&s);
  for (int stored = 0; stored < 2; ++stored) {
    const char *failed = "";
    const long held = shim_references();
    for (int n = 1; failed; ++n) {
      memory m = {.count = 0};
      if (stored)
        assert_int_equal(make_plan(&s.config, &m), HBIL_SUCCESS);
      hbil_context *context = new_context(&m);
      hbil_plan *plan = NULL;
      shim_fail(n, CL_OUT_OF_RESOURCES);
      const hbil_status status = hbil_plan_create(context, &s.config, &plan);
      failed = shim_failed();
      shim_fail(0, CL_SUCCESS);
      /* without binaries, the build itself is what fails */
      const bool succeeds =
          !failed || (is_dispensable(failed) &&
                      (stored || strcmp(failed, "clBuildProgram") != 0));
      if (succeeds != (status == HBIL_SUCCESS))
        fail_msg("call %d, %s: \"%s\"", n, failed ? failed : "none",
                 hbil_status_string(status));
      hbil_plan_destroy(plan);
      hbil_context_destroy(context);
      assert_int_equal(shim_references(), held);
      memory_free(&m);
    }
  }
  setup_free(&s);
}

TEST(a_store_has_two_functions) {
  hbil_context *c = shared_device.hbil;
  assert_int_equal(hbil_context_set_program_store(NULL, load, store, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(NULL), ": context must"));
  assert_int_equal(hbil_context_set_program_store(c, load, NULL, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(c), ": store must"));
  assert_int_equal(hbil_context_set_program_store(c, NULL, store, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(c), ": load must"));
  assert_int_equal(hbil_context_set_program_store(c, NULL, NULL, NULL),
                   HBIL_SUCCESS);
  assert_int_equal(hbil_context_set_program_folder(c, NULL),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(c), ": folder must"));
  assert_int_equal(hbil_context_set_program_folder(c, ""),
                   HBIL_INVALID_ARGUMENT);
  assert_non_null(strstr(hbil_context_message(c), ": folder: empty"));
}

/* ------------------------------------------------------------------------ */
/* A folder                                                                  */

/* Another process with an empty cache of PoCL: this program, whose environment
 * has FOLDER_VARIABLE. */
#define FOLDER_VARIABLE "HBIL_TEST_PROGRAMS"
#define PROGRAM_VARIABLE "HBIL_TEST_PROGRAM"
static const char *program;

static int count_warnings;
static void count_warning(hbil_message_kind kind, const char *message,
                          void *user) {
  (void)message;
  (void)user;
  count_warnings += kind == HBIL_MESSAGE_WARNING;
}

static void use_folder(const char *folder) {
  count_warnings = 0;
  hbil_context_set_callback(shared_device.hbil, count_warning, NULL);
  assert_int_equal(hbil_context_set_program_folder(shared_device.hbil, folder),
                   HBIL_SUCCESS);
}

static void use_no_folder(void) {
  hbil_context_set_callback(shared_device.hbil, NULL, NULL);
  hbil_context_set_program_store(shared_device.hbil, NULL, NULL, NULL);
}

TEST(create_plan) {
  setup s;
  use_folder(getenv(FOLDER_VARIABLE));
  ao_alone(&s);
  setup_start_compiled(&s);
  setup_run(&s, hbil_enqueue_frame);
  setup_free(&s);
  assert_int_equal(count_warnings, 0);
  use_no_folder();
}

/* What PoCL leaves of each compiled program, and of each kernel. */
typedef struct compiled {
  int programs, kernels;
} compiled;

static compiled run_process(const char *folder) {
  char cache[MOST_PATH];
  folder_make(cache);
  setenv(FOLDER_VARIABLE, folder, 1);
  setenv("POCL_CACHE_DIR", cache, 1);
  setenv("POCL_LEAVE_KERNEL_COMPILER_TEMP_FILES", "1", 1);
  setenv(PROGRAM_VARIABLE, program, 1);
  /* its own results are no test's of this process */
  const int status = system("exec \"$" PROGRAM_VARIABLE "\" >/dev/null");
  unsetenv(PROGRAM_VARIABLE);
  unsetenv(FOLDER_VARIABLE);
  unsetenv("POCL_LEAVE_KERNEL_COMPILER_TEMP_FILES");
  assert_true(WIFEXITED(status));
  assert_int_equal(WEXITSTATUS(status), 0);
  const compiled files = {folder_count(cache, ".cl"),
                          folder_count(cache, ".so.o")};
  folder_remove(cache);
  return files;
}

TEST(another_process_compiles_nothing) {
  char folder[MOST_PATH], empty[MOST_PATH];
  setup s;
  skip_unless_pocl();
  folder_make(folder);
  folder_make(empty);
  ao_alone(&s);
  use_folder(folder);
  setup_start_compiled(&s);
  setup_free(&s);
  use_no_folder();
  const int programs = folder_count(folder, ".bin");
  assert_in_range(programs, 4, 10);
  assert_int_equal(folder_count(folder, ""), programs);
  const compiled first = run_process(empty), later = run_process(folder);
  assert_int_equal(first.programs, programs);
  assert_true(first.kernels >= programs);
  assert_int_equal(later.programs, 0);
  assert_int_equal(later.kernels, 0);
  folder_remove(folder);
  folder_remove(empty);
}

/* Puts something else in the place of every stored program. */
typedef void replacement(const char *path);
static void put_fifo(const char *path) {
  assert_int_equal(remove(path), 0);
  assert_int_equal(mkfifo(path, 0666), 0);
}
static void put_endless_device(const char *path) {
  assert_int_equal(remove(path), 0);
  assert_int_equal(symlink("/dev/zero", path), 0);
}
static void put_large_file(const char *path) {
  assert_int_equal(truncate(path, 3000000000l), 0);
}
static void put_folder(const char *path) {
  assert_int_equal(remove(path), 0);
  assert_int_equal(mkdir(path, 0777), 0);
}

static int replace_all(const char *folder, replacement *put) {
  DIR *entries = opendir(folder);
  int count = 0;
  assert_non_null(entries);
  for (struct dirent *e; (e = readdir(entries));)
    if (e->d_name[0] != '.') {
      char path[2 * MOST_PATH];
      snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
      put(path);
      count++;
    }
  closedir(entries);
  return count;
}

/* Nothing is waited for and nothing endless is read, programs are built and
 * stored in place of what was there. */
TEST(only_regular_files_are_programs) {
  static replacement *const all[] = {put_fifo, put_endless_device,
                                     put_large_file, put_folder};
  char folder[MOST_PATH];
  setup s;
  folder_make(folder);
  ao_alone(&s);
  for (size_t i = 0; i <= sizeof all / sizeof *all; ++i) {
    hbil_plan *plan = NULL;
    use_folder(folder);
    alarm(120); /* the process ends where it would wait for ever */
    assert_int_equal(hbil_plan_create(shared_device.hbil, &s.config, &plan),
                     HBIL_SUCCESS);
    alarm(0);
    hbil_plan_destroy(plan);
    const int programs = folder_count(folder, ".bin");
    assert_in_range(programs, 4, 10);
    assert_int_equal(folder_count(folder, ""), programs);
    /* that a file is damaged is told; what is none isn't there */
    assert_int_equal(count_warnings,
                     i && all[i - 1] == put_large_file ? programs : 0);
    use_no_folder();
    if (i < sizeof all / sizeof *all)
      assert_int_equal(replace_all(folder, all[i]), programs);
  }
  folder_remove(folder);
  setup_free(&s);
}

TEST(folders_may_be_missing) {
  setup s;
  ao_alone(&s);
  use_folder("/no such folder");
  setup_start_compiled(&s);
  assert_int_equal(count_warnings, 1);
  use_no_folder();
  setup_free(&s);
}

int main(int argc, char **argv) {
  (void)argc;
  program = argv[0];
  const bool child = getenv(FOLDER_VARIABLE) != NULL;
  cmocka_set_skip_filter(child ? NULL : "create_plan");
  cmocka_set_test_filter(child ? "create_plan" : getenv("HBIL_TEST_FILTER"));
  return run_with_device();
}
