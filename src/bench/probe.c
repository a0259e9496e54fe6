/*
 * A plan in a process of its own: `hbil bench --probe`, and the bench starting
 * itself that way.  PoCL decides once a process how many threads it uses, and
 * keeps every kernel that it has loaded.
 */
#define _POSIX_C_SOURCE 200809L
#include "bench/bench.h"

#include <jansson.h>

#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* --- in that process --- */

static int measure(const bench_options *options, const device *d,
                   bench_probe *out, image_error *error) {
  const bench_configuration standard = bench_default();
  bench_content content;
  bench_turn turn = {.lab = NULL};
  bench_timing timing;
  cl_uint units = 0;
  clGetDeviceInfo(d->id, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units,
                  NULL);
  if (bench_content_load(options, &content, error) != 0)
    return -1;
  bench_configure(&content, &standard, &turn.config);
  const int failed =
      bench_lab_open(d, &content, &turn.lab, error) != 0 ||
      bench_lab_start(turn.lab, &turn.config, &out->start, error) != 0 ||
      bench_lab_turns(&turn, 1, options->runs, &timing, error) != 0;
  out->units = units;
  if (!failed) {
    out->total = timing.total.median;
    out->gather = timing.pass[HBIL_PASS_GATHER].median;
  }
  bench_lab_close(turn.lab);
  bench_content_free(&content);
  return failed ? -1 : 0;
}

static int print(const bench_probe *p, image_error *error) {
  const double *frame = p->start.frame;
  json_t *root = json_pack("{s:i, s:f, s:[f, f, f], s:f, s:f}", "compute_units",
                           (int)p->units, "plan_ms", p->start.plan, "frames_ms",
                           frame[0], frame[1], frame[2], "frame_ms", p->total,
                           "gather_ms", p->gather);
  const int failed = !root || json_dumpf(root, stdout, JSON_COMPACT) != 0;
  json_decref(root);
  putchar('\n');
  return failed ? image_no_memory(error, "the probe") : 0;
}

int bench_probe_print(const bench_options *options, image_error *error) {
  device d;
  bench_probe probe;
  if (device_open(options->device, 1, &d, error) != 0)
    return -1;
  const int failed =
      measure(options, &d, &probe, error) != 0 || print(&probe, error) != 0;
  device_close(&d);
  return failed ? -1 : 0;
}

/* --- starting it --- */

/* Of PoCL until 3, and from 4 on. */
static char one_thread[] = "POCL_MAX_PTHREAD_COUNT=1";
static char one_unit[] = "POCL_CPU_MAX_CU_COUNT=1";

static int same_name(const char *a, const char *b) {
  const size_t length = strcspn(a, "=");
  return length == strcspn(b, "=") && strncmp(a, b, length) == 0;
}

/* Ours with those two; the caller frees it alone. */
static char **single_thread_environment(void) {
  size_t count = 0, kept = 0;
  while (environ[count])
    count++;
  char **out = malloc((count + 3) * sizeof *out);
  for (size_t i = 0; out && i < count; i++)
    if (!same_name(environ[i], one_thread) && !same_name(environ[i], one_unit))
      out[kept++] = environ[i];
  if (out) {
    out[kept++] = one_thread;
    out[kept++] = one_unit;
    out[kept] = NULL;
  }
  return out;
}

/* What it prints goes into the pipe. */
static int spawn(char *const *arguments, char *const *variables, int pipe_end,
                 pid_t *child) {
  posix_spawn_file_actions_t actions;
  int status = posix_spawn_file_actions_init(&actions);
  if (status != 0)
    return status;
  status = posix_spawn_file_actions_adddup2(&actions, pipe_end, STDOUT_FILENO);
  if (status == 0)
    status = posix_spawn(child, "/proc/self/exe", &actions, NULL, arguments,
                         variables);
  posix_spawn_file_actions_destroy(&actions);
  return status;
}

static int parse(FILE *in, bench_probe *out) {
  json_t *root = json_loadf(in, 0, NULL);
  int units = 0;
  double *frame = out->start.frame;
  const int failed =
      !root ||
      json_unpack(root, "{s:i, s:F, s:[F, F, F], s:F, s:F}", "compute_units",
                  &units, "plan_ms", &out->start.plan, "frames_ms", &frame[0],
                  &frame[1], &frame[2], "frame_ms", &out->total, "gather_ms",
                  &out->gather) != 0;
  out->units = (unsigned)units;
  json_decref(root);
  return failed;
}

/* Reads all that it tells, and waits for its end. */
static int collect(int pipe_end, pid_t child, bench_probe *out) {
  FILE *in = fdopen(pipe_end, "r");
  int failed = !in || parse(in, out), status = 1;
  if (in)
    fclose(in);
  else
    close(pipe_end);
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR)
      return -1;
  return failed || !WIFEXITED(status) || WEXITSTATUS(status) != 0;
}

static int run(char *const *arguments, char *const *variables, bench_probe *out,
               image_error *error) {
  int ends[2];
  pid_t child;
  if (pipe(ends) != 0)
    return image_fail(error, "no pipe to another process: %s", strerror(errno));
  const int status = spawn(arguments, variables, ends[1], &child);
  close(ends[1]); /* or the end of what it prints is never seen */
  if (status != 0) {
    close(ends[0]);
    return image_fail(error, "hbil cannot be started once more: %s",
                      strerror(status));
  }
  return collect(ends[0], child, out) == 0
             ? 0
             : image_fail(error, "hbil bench --probe has failed");
}

int bench_probe_run(const bench_options *options, uint32_t width,
                    uint32_t height, int single_thread, bench_probe *out,
                    image_error *error) {
  char name[] = "hbil", command[] = "bench", probe[] = "--probe";
  char size[64], runs[64], chosen[300] = "";
  char *arguments[] = {name, command, probe, size, runs, chosen, NULL};
  char **variables = single_thread ? single_thread_environment() : environ;
  memset(out, 0, sizeof *out);
  if (!variables)
    return image_no_memory(error, "the environment");
  snprintf(size, sizeof size, "--size=%ux%u", width, height);
  snprintf(runs, sizeof runs, "--runs=%u", options->runs);
  if (options->device)
    snprintf(chosen, sizeof chosen, "--device=%s", options->device);
  else
    arguments[5] = NULL;
  const int failed = run(arguments, variables, out, error);
  if (single_thread)
    free(variables);
  return failed;
}
