#define _DEFAULT_SOURCE 1 /* getentropy() */
#include "image/temporary_name.h"

#include <fcntl.h>
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The parts of .hbil-d791a068-0123456789abcdef.tmp. */
static const char head[] = ".hbil-", tail[] = ".tmp";
enum {
  HEAD = sizeof head - 1,
  MACHINE = 8,
  NUMBER = 16,
  TAIL = sizeof tail - 1,
  LENGTH = HEAD + MACHINE + 1 + NUMBER + TAIL
};

/* The beginning of the boot's number, which Linux draws when it starts; the
 * host's name elsewhere. */
static void machine(char out[MACHINE + 1]) {
  char host[256] = "";
  uint32_t hash = 2166136261u;
  const int fd = open("/proc/sys/kernel/random/boot_id", O_RDONLY | O_CLOEXEC);
  const int found = fd >= 0 && read(fd, out, MACHINE) == MACHINE;
  if (fd >= 0)
    close(fd);
  out[MACHINE] = '\0';
  if (found && strspn(out, "0123456789abcdef") == MACHINE)
    return;
  gethostname(host, sizeof host - 1);
  for (const char *c = host; *c; c++)
    hash = (hash ^ (unsigned char)*c) * 16777619u;
  snprintf(out, MACHINE + 1, "%08" PRIx32, hash);
}

char *temporary_name_new(const char *path) {
  const char *slash = strrchr(path, '/');
  const size_t folder = slash ? (size_t)(slash - path) + 1 : 0;
  char *name = malloc(folder + LENGTH + 1);
  if (name) {
    memcpy(name, path, folder);
    name[folder] = '\0';
  }
  return name;
}

void temporary_name_draw(char *name) {
  char *slash = strrchr(name, '/'), *file = slash ? slash + 1 : name;
  char own[MACHINE + 1];
  uint64_t number;
  if (getentropy(&number, sizeof number) != 0) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    number =
        ((uint64_t)now.tv_sec << 30 ^ (uint64_t)now.tv_nsec) * 0x9e3779b9u ^
        (uint64_t)getpid() << 40;
  }
  machine(own);
  snprintf(file, LENGTH + 1, "%s%s-%016" PRIx64 "%s", head, own, number, tail);
}

int temporary_name_is(const char *name) {
  const char *digits = "0123456789abcdef";
  return strlen(name) == LENGTH && !memcmp(name, head, HEAD) &&
         strspn(name + HEAD, digits) == MACHINE &&
         name[HEAD + MACHINE] == '-' &&
         strspn(name + HEAD + MACHINE + 1, digits) == NUMBER &&
         !memcmp(name + LENGTH - TAIL, tail, TAIL);
}

int temporary_name_is_local(const char *name) {
  char own[MACHINE + 1];
  machine(own);
  return !memcmp(name + HEAD, own, MACHINE);
}
