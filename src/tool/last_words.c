/* One line where a driver ends the process. */
#define _DEFAULT_SOURCE 1 /* strsignal(), sigaction() */
#include "tool/last_words.h"

#include "tool/report.h"
#include "tool/uncaught.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *_Atomic driver_does;
static atomic_flag said = ATOMIC_FLAG_INIT;

/* What can be called in a handler is little: write() is, printf() isn't. */
static void say(const char *text) {
  size_t left = strlen(text);
  while (left > 0) {
    const ssize_t done = write(STDERR_FILENO, text, left);
    if (done <= 0)
      return;
    text += done;
    left -= (size_t)done;
  }
}

/* The first thread that comes here says it, and ends the process. */
static void end_process(const char *why) {
  const char *doing = driver_does;
  if (atomic_flag_test_and_set(&said))
    for (;;)
      pause();
  say("hbil: ");
  say(why);
  if (doing) {
    say(" while the OpenCL driver ");
    say(doing);
    say("; what it said may stand above; it needs memory (ulimit -v) and, for "
        "compiled kernels, room on the disk (POCL_CACHE_DIR, ulimit -f)");
  }
  say("\n");
  _exit(STATUS_BAD_INPUT);
}

static const struct {
  int signal;
  const char *text;
} deaths[] = {{SIGABRT, "the process was aborted"},
              {SIGSEGV, "the process used memory that it hasn't (SIGSEGV)"},
              {SIGBUS, "the process lost memory that it had (SIGBUS)"},
              {SIGILL, "the process met an instruction that the machine hasn't "
                       "(SIGILL)"},
              {SIGFPE, "the process divided by zero (SIGFPE)"}};
enum { DEATHS = sizeof deaths / sizeof *deaths };

static void die(int signal) {
  for (int i = 0; i < DEATHS; i++)
    if (deaths[i].signal == signal)
      end_process(deaths[i].text);
}

/* Runs at exit(), which main() calls with nothing under way. */
static void check_exit(void) {
  if (driver_does)
    end_process("the process was ended");
}

/* Sanitizers have handlers of their own, which stay. */
static int take_signal(int signal) {
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = die;
  return sigaction(signal, &action, NULL);
}

static int is_taken[DEATHS];

void last_words_prepare(void) {
  for (int i = 0; i < DEATHS; i++) {
    struct sigaction before;
    is_taken[i] = sigaction(deaths[i].signal, NULL, &before) == 0 &&
                  before.sa_handler == SIG_DFL &&
                  take_signal(deaths[i].signal) == 0;
  }
  uncaught_prepare(end_process);
  atexit(check_exit);
}

/* LLVM, which is in drivers, puts handlers of its own in front when it compiles
 * for the first time; abort() ends the process behind the first handler. */
void last_words_driver(const char *doing) {
  for (int i = 0; i < DEATHS; i++)
    if (is_taken[i])
      take_signal(deaths[i].signal);
  driver_does = doing;
}
