/*
 * One set of defaults: without options, the tool computes with the settings of
 * hbil_config_init().  The rows of its options fit together.
 */
#include "test/support/compare.h"

#include <getopt.h>

#include "dump/roles.h"
#include "image/error.h"
#include "tool/process_arguments.h"
#include "tool/process_options.h"
#include "tool/source_arguments.h"

/* Every member of hbil_config behind its size, in order. */
typedef struct member {
  const char *name;
  size_t offset, size;
} member;
#define MEMBER(name)                                                           \
  { #name, offsetof(hbil_config, name), sizeof(((hbil_config *)0)->name) }

static const member members[] = {
    MEMBER(struct_size),
    MEMBER(width),
    MEMBER(height),
    MEMBER(inputs.depth),
    MEMBER(inputs.normal),
    MEMBER(inputs.albedo),
    MEMBER(inputs.f0),
    MEMBER(inputs.direct),
    MEMBER(inputs.emission),
    MEMBER(inputs.motion),
    MEMBER(inputs.projection),
    MEMBER(inputs.depth_kind),
    MEMBER(inputs.sky_depth),
    MEMBER(inputs.normal_space),
    MEMBER(inputs.direct_scale),
    MEMBER(inputs.motion_scale),
    MEMBER(inputs.normal_encoding),
    MEMBER(inputs.depth_scale),
    MEMBER(inputs.normal_scale),
    MEMBER(inputs.direct_kind),
    MEMBER(outputs.near_irradiance),
    MEMBER(outputs.far_irradiance),
    MEMBER(outputs.ao),
    MEMBER(outputs.bent_normal),
    MEMBER(outputs.cone_cosine),
    MEMBER(outputs.indirect),
    MEMBER(outputs.beauty),
    MEMBER(outputs.error_estimate),
    MEMBER(outputs.unknown),
    MEMBER(outputs.glossy),
    MEMBER(outputs.bent_normal_space),
    MEMBER(model.mode),
    MEMBER(model.falloff),
    MEMBER(model.radius),
    MEMBER(model.thickness),
    MEMBER(model.relative_thickness),
    MEMBER(model.extrapolate),
    MEMBER(model.facing_fade),
    MEMBER(model.back_facing_fallback),
    MEMBER(model.gather_emission),
    MEMBER(model.feedback),
    MEMBER(model.far_field),
    MEMBER(model.offscreen_light),
    MEMBER(model.cache_method),
    MEMBER(model.roughness),
    MEMBER(model.ao_bounces),
    MEMBER(model.ao_radius),
    MEMBER(model.near_relative_thickness),
    MEMBER(sampling.slices),
    MEMBER(sampling.steps_per_side),
    MEMBER(sampling.step_growth),
    MEMBER(sampling.sample_grid),
    MEMBER(sampling.resolution),
    MEMBER(sampling.unfiltered),
    MEMBER(sampling.storage),
    MEMBER(sampling.slice_frames),
    MEMBER(history.reprojection),
    MEMBER(history.disocclusion_threshold),
    MEMBER(execution.skip),
    MEMBER(execution.vector_width),
    MEMBER(execution.profiling),
};
enum { MEMBERS = sizeof members / sizeof *members };

/* A member that was added to the header must be added here, too: all lie side
 * by side, and the struct ends behind the last one but for its padding. */
TEST(all_members_are_compared) {
  size_t end = 0;
  for (int i = 0; i < MEMBERS; ++i) {
    const size_t at = members[i].offset;
    if (at != end)
      fail_msg("there is a member before %s", members[i].name);
    end = at + members[i].size;
  }
  assert_in_range(end, sizeof(hbil_config) - sizeof(size_t) + 1,
                  sizeof(hbil_config));
}

static void compare(const hbil_config *got) {
  hbil_config want;
  hbil_config_init(&want);
  for (int i = 0; i < MEMBERS; ++i)
    if (memcmp((const char *)got + members[i].offset,
               (const char *)&want + members[i].offset, members[i].size))
      fail_msg("%s is another in the tool", members[i].name);
}

/* The settings of a command line. */
static process_settings settings_of(int count, char *const *words) {
  char *argv[8] = {(char[]){"hbil process"}};
  process_arguments arguments;
  image_error error;
  for (int i = 0; i < count; ++i)
    argv[1 + i] = words[i];
  optind = 0; /* getopt starts anew */
  assert_int_equal(process_arguments_read(1 + count, argv, &arguments, &error),
                   0);
  return arguments.settings;
}

TEST(without_options_they_are_the_librarys) {
  char *words[] = {(char[]){"frame.exr"}};
  const process_settings s = settings_of(1, words);
  compare(&s.config);
}

TEST(the_default_model_sets_nothing_else) {
  char *words[] = {(char[]){"--model"}, (char[]){"paper"}, (char[]){"--model"},
                   (char[]){"default"}, (char[]){"frame.exr"}};
  const process_settings s = settings_of(5, words);
  compare(&s.config);
}

/* The option whose member has this offset, and how many options have it. */
static const option_row *option_of(size_t offset, int *count) {
  const option_row *found = NULL;
  *count = 0;
  for (size_t g = 0; g < PROCESS_GROUPS; ++g)
    for (size_t i = 0; i < process_groups[g].count; ++i) {
      const option_row *row = &process_groups[g].rows[i];
      if (row->kind == OPTION_MORE || row->member != offset)
        continue;
      found = row;
      ++*count;
    }
  return found;
}

static void check_relation(const option_row *row, const option_relation *r) {
  int count;
  const option_row *other = option_of(r->other, &count);
  if (!other)
    fail_msg("--%s needs or excludes what is no option", row->name);
  if (r->choices && other->kind != OPTION_CHOICE)
    fail_msg("--%s: --%s has no choices", row->name, other->name);
  unsigned possible = 0;
  for (unsigned w = 0; r->choices && other->words[w]; ++w)
    possible |= 1u << (other->low + w);
  if (r->choices & ~possible)
    fail_msg("--%s: --%s has no such choice", row->name, other->name);
}

/* The parser passes over relations to options that there are not. */
TEST(options_need_and_exclude_options) {
  int relations = 0, count;
  for (size_t g = 0; g < PROCESS_GROUPS; ++g)
    for (size_t i = 0; i < process_groups[g].count; ++i) {
      const option_row *row = &process_groups[g].rows[i];
      if (row->kind == OPTION_MORE)
        continue;
      option_of(row->member, &count);
      if (count != 1)
        fail_msg("--%s has the member of another option", row->name);
      for (int k = 0; k < OPTION_RELATIONS && row->relations[k].why; ++k) {
        check_relation(row, &row->relations[k]);
        relations++;
      }
    }
  assert_true(relations > 30);
}

/* The help is a text, so no list of names can write it. */
TEST(the_help_names_every_role) {
  const char *help = NULL;
  for (int i = 0; i < SOURCE_ROWS; ++i)
    if (source_rows[i].name && !strcmp(source_rows[i].name, "map"))
      help = source_rows[i].help;
  assert_non_null(help);
  for (int r = 0; r < ROLE_COUNT; ++r)
    if (!strstr(help, role_name((role)r)))
      fail_msg("--map doesn't name %s", role_name((role)r));
}

int main(void) {
  return tests_run();
}
