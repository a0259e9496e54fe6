/* Which files of a folder are frames, and which are their truth. */
#define _XOPEN_SOURCE 700 /* realpath() */
#include "bench/truth_scene.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "bench/colour.h"
#include "dump/frame_camera.h"
#include "image/camera_json.h"
#include "image/exr_read.h"
#include "tool/paths.h"

/* Layers of a frame that hold its truth; of any other file R, G, B do, too. */
static const char *const own_layers[] = {"DiffInd", "Diffuse Indirect",
                                         "indirect", NULL};
static const char *const layers[] = {"DiffInd", "Diffuse Indirect", "indirect",
                                     "", NULL};

static const char frame_prefix[] = "frame_", truth_suffix[] = "_truth.exr",
                  average_prefix[] = "truth_avg_";

static int is_there(const char *path) {
  return path && access(path, F_OK) == 0;
}

/* --- names in a folder --- */

static const char *frame_digits(const char *name) {
  return name + strlen(frame_prefix);
}

static int ends_with(const char *name, const char *end) {
  const size_t length = strlen(name), tail = strlen(end);
  return length > tail && strcmp(name + length - tail, end) == 0;
}

static int is_frame(const struct dirent *entry) {
  const char *name = entry->d_name;
  if (strncmp(name, frame_prefix, strlen(frame_prefix)) != 0)
    return 0;
  const size_t digits = strspn(frame_digits(name), "0123456789");
  return digits > 0 && strcmp(frame_digits(name) + digits, ".exr") == 0;
}

static int is_truth(const struct dirent *entry) {
  return ends_with(entry->d_name, truth_suffix);
}

static int by_number(const struct dirent **a, const struct dirent **b) {
  const unsigned long long x = strtoull(frame_digits((*a)->d_name), NULL, 10);
  const unsigned long long y = strtoull(frame_digits((*b)->d_name), NULL, 10);
  return x == y ? strcmp((*a)->d_name, (*b)->d_name) : (x > y) - (x < y);
}

static void free_list(struct dirent **list, int count) {
  for (int i = 0; i < count; i++)
    free(list[i]);
  free(list);
}

/* --- frame_NNNN.exr --- */

static int take_frames(const char *folder, struct dirent *const *list,
                       size_t count, truth_scene *out, image_error *error) {
  out->frames = calloc(count, sizeof *out->frames);
  for (size_t i = 0; out->frames && i < count; i++) {
    out->frames[i] = path_join(folder, "/", list[i]->d_name);
    if (!out->frames[i])
      break;
    out->count++;
  }
  return out->count == count ? 0 : image_no_memory(error, folder);
}

/* FOLDER/WHAT_NNNN.exr for the last frame; NULL when out of memory. */
static char *beside_last(const truth_scene *s, const char *folder,
                         const char *what) {
  const char *name = strrchr(s->frames[s->count - 1], '/') + 1;
  char *start = path_join(folder, "/", what);
  char *path = start ? path_join(start, "_", frame_digits(name)) : NULL;
  free(start);
  return path;
}

static int has_indirect(const char *path, int *out, image_error *error) {
  compare_side side = {0};
  const char *names[3];
  if (exr_read_header(path, &side.header, error) != 0)
    return -1;
  *out = bench_colour_find(&side.header, own_layers, names);
  compare_side_free(&side);
  return 0;
}

/* The frame was traced itself. */
static int take_own_truth(const char *folder, truth_scene *out,
                          image_error *error) {
  free(out->truth);
  out->truth = strdup(out->frames[out->count - 1]);
  return out->truth ? 0 : image_no_memory(error, folder);
}

/* --- the truth of the folder above --- */

static int is_average(const struct dirent *entry) {
  const char *name = entry->d_name;
  return strncmp(name, average_prefix, strlen(average_prefix)) == 0 &&
         ends_with(name, ".exr");
}

/* FOLDER/frame_NNNN.json for a truth_avg_NNNN.exr; NULL when out of memory. */
static char *camera_of_truth(const char *folder, const char *average) {
  char *start = path_join(folder, "/", "frame_");
  char *frame =
      start ? path_join(start, "", average + strlen(average_prefix)) : NULL;
  char *camera = frame ? camera_file_beside(frame) : NULL;
  free(start);
  free(frame);
  return camera;
}

/* Renderers store single precision, and know a camera by its matrix. */
static int is_same_camera(const camera_file *a, const camera_file *b) {
  int same = a->orthographic == b->orthographic &&
             fabs(a->fx - b->fx) < 1e-4 * a->fx &&
             fabs(a->fy - b->fy) < 1e-4 * a->fy;
  for (int i = 0; i < 16; i++)
    same = same && fabs(a->camera_to_world[i] - b->camera_to_world[i]) < 1e-4;
  return same;
}

static int check_camera(const char *truth, const char *its, const char *last,
                        image_error *error) {
  camera_file a, b;
  char *own = camera_file_beside(last);
  if (!own || !its) {
    free(own);
    return image_no_memory(error, last);
  }
  int failed =
      camera_read(its, &a, error) != 0 || camera_read(own, &b, error) != 0;
  if (!failed && !is_same_camera(&a, &b))
    failed = image_fail(error,
                        "%s: another camera than that of %s; the truth of this "
                        "frame is needed",
                        truth, last);
  free(own);
  return failed ? -1 : 0;
}

/* PARENT/FOLDER in place of FOLDER, which many scenes may have. */
static int name_by_parent(const char *parent, truth_scene *out,
                          image_error *error) {
  const char *slash = strrchr(parent, '/');
  char *name =
      path_join(slash && slash[1] ? slash + 1 : parent, "/", out->name);
  if (!name)
    return image_no_memory(error, parent);
  free(out->name);
  out->name = name;
  return 0;
}

static int take_average(const char *parent, const char *average,
                        truth_scene *out, image_error *error) {
  char *camera = camera_of_truth(parent, average);
  free(out->truth);
  out->truth = path_join(parent, "/", average);
  const int failed =
      !out->truth ? image_no_memory(error, parent)
                  : check_camera(out->truth, camera,
                                 out->frames[out->count - 1], error) != 0 ||
                        name_by_parent(parent, out, error) != 0;
  free(camera);
  return failed ? -1 : 0;
}

static int take_truth_above(const char *folder, truth_scene *out,
                            image_error *error) {
  struct dirent **list = NULL;
  const char *last = strrchr(out->frames[out->count - 1], '/') + 1;
  char *whole = realpath(folder, NULL); /* it may be called "." */
  char *parent = whole ? path_parent(whole) : NULL;
  free(whole);
  if (!parent)
    return image_no_memory(error, folder);
  const int count = scandir(parent, &list, is_average, alphasort);
  const int failed =
      count > 0 ? take_average(parent, list[count - 1]->d_name, out, error)
                : image_fail(error,
                             "%s: no truth; truth_avg_NNNN.exr of the last "
                             "frame %s, here or in the folder above, or "
                             "DiffInd in that file, is needed",
                             folder, last);
  if (list)
    free_list(list, count);
  free(parent);
  return failed;
}

static int take_sequence(const char *folder, struct dirent *const *list,
                         size_t count, truth_scene *out, image_error *error) {
  int traced;
  if (take_frames(folder, list, count, out, error) != 0)
    return -1;
  out->truth = beside_last(out, folder, "truth_avg");
  if (!out->truth)
    return image_no_memory(error, folder);
  if (is_there(out->truth))
    return 0;
  if (has_indirect(out->frames[out->count - 1], &traced, error) != 0)
    return -1;
  return traced ? take_own_truth(folder, out, error)
                : take_truth_above(folder, out, error);
}

/* --- NAME.exr and NAME_truth.exr --- */

/* Looks for PREFIX_truth.exr, then without the last _PART of the name. */
static int take_truth(const char *prefix, truth_scene *out,
                      image_error *error) {
  char *stem = strdup(prefix);
  char *cut = stem;
  while (cut && !is_there(out->truth)) {
    const char *slash = strrchr(stem, '/');
    free(out->truth);
    out->truth = path_join(stem, "", truth_suffix);
    cut = out->truth ? strrchr(stem, '_') : NULL;
    if (cut && (cut == stem || (slash && cut <= slash + 1)))
      cut = NULL;
    if (cut)
      *cut = '\0';
  }
  free(stem);
  if (!out->truth)
    return image_no_memory(error, prefix);
  return is_there(out->truth)
             ? 0
             : image_fail(error, "%s.exr: no truth; %s%s is needed", prefix,
                          prefix, truth_suffix);
}

static int take_single(const char *prefix, truth_scene *out,
                       image_error *error) {
  char *frame = path_join(prefix, "", ".exr");
  out->frames = calloc(1, sizeof *out->frames);
  if (!frame || !out->frames) {
    free(frame);
    return image_no_memory(error, prefix);
  }
  out->frames[0] = frame;
  out->count = 1;
  return is_there(frame)
             ? take_truth(prefix, out, error)
             : image_fail(error,
                          "%s: no such folder; a folder of frames, or "
                          "FOLDER/NAME of NAME.exr, is needed",
                          prefix);
}

/* The only NAME for which there are NAME.exr and NAME_truth.exr. */
static int take_pair(const char *folder, struct dirent *const *list,
                     size_t count, truth_scene *out, image_error *error) {
  if (count == 0)
    return image_fail(error,
                      "%s: no frames; frame_NNNN.exr, or NAME.exr with "
                      "NAME_truth.exr, are needed",
                      folder);
  if (count > 1)
    return image_fail(error,
                      "%s: %zu files NAME_truth.exr; FOLDER/NAME of one of "
                      "them is needed",
                      folder, count);
  char *prefix = path_join(folder, "/", list[0]->d_name);
  if (!prefix)
    return image_no_memory(error, folder);
  prefix[strlen(prefix) - strlen(truth_suffix)] = '\0';
  const int failed = take_single(prefix, out, error);
  free(prefix);
  return failed;
}

/* --- an argument --- */

static int look_into(const char *folder, truth_scene *out, image_error *error) {
  struct dirent **list = NULL;
  int count = scandir(folder, &list, is_frame, by_number);
  const int frames = count > 0;
  if (count == 0) {
    free(list);
    list = NULL;
    count = scandir(folder, &list, is_truth, alphasort);
  }
  if (count < 0)
    return image_fail(error, "%s: cannot be read: %s", folder, strerror(errno));
  const int failed = (frames ? take_sequence : take_pair)(
      folder, list, (size_t)count, out, error);
  free_list(list, count);
  return failed;
}

int truth_scene_find(const char *argument, truth_scene *out,
                     image_error *error) {
  struct stat info;
  memset(out, 0, sizeof *out);
  char *path = strdup(argument);
  if (!path)
    return image_no_memory(error, argument);
  for (size_t end = strlen(path); end > 1 && path[end - 1] == '/'; end--)
    path[end - 1] = '\0';
  const char *slash = strrchr(path, '/');
  out->name = strdup(slash && slash[1] ? slash + 1 : path);
  int failed = out->name ? 0 : image_no_memory(error, argument);
  if (!failed)
    failed = stat(path, &info) == 0 && S_ISDIR(info.st_mode)
                 ? look_into(path, out, error)
                 : take_single(path, out, error);
  free(path);
  return failed;
}

void truth_scene_free(truth_scene *s) {
  for (size_t i = 0; i < s->count; i++)
    free(s->frames[i]);
  free(s->frames);
  free(s->name);
  free(s->truth);
  memset(s, 0, sizeof *s);
}

/* --- its light --- */

int truth_scene_read(const truth_scene *s, compare_side *out,
                     image_error *error) {
  const int own = strcmp(s->truth, s->frames[s->count - 1]) == 0;
  return bench_colour_read(s->truth, own ? own_layers : layers, out, error);
}
