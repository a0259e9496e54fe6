/* The settings of a job. */
#include "tool/settings.h"

#include "image/exr_style.h"
#include "tool/model.h"

#include <string.h>

const char *const mode_words[] = {"hbil", "gtao", "hbao", NULL};
const char *const falloff_words[] = {"linear", "soft", "none", NULL};

void process_settings_init(process_settings *settings) {
  memset(settings, 0, sizeof *settings);
  hbil_config_init(&settings->config);
  source_options_init(&settings->source);
  settings->warm_up = model_warm_up(HBIL_MODEL_DEFAULT);
  settings->repeat = 1;
  settings->horizon_cache = HORIZON_CACHE_CHOOSE;
  /* Writing with piz takes 6 to 12 times as long, for .6 to .7 of the bytes:
   * at 1280x720, .4 to 1 s instead of .07 to .09 on two cores, which is longer
   * than lighting a frame takes (doc/measurements.md). */
  settings->compression = EXR_COMPRESSION_OF_NONE;
}
