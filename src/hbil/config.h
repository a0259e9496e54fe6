/* Defaults and presets, and the rejection of what is out of range. */
#ifndef HBIL_CONFIG_H
#define HBIL_CONFIG_H

#include <stdbool.h>

#include "context.h"

/* Copies a caller's struct into one of this library's size.  A program compiled
 * against an older header passes a smaller struct; the missing members get
 * their defaults.  Every public function that takes a config or a frame calls
 * these first. They reject sizes that no header has had; config_take() also
 * rejects values out of range, by the name of the field and its range, and
 * replaces HBIL_FAR_AUTO by what it stands for. */
hbil_status config_take(hbil_context *context, const hbil_config *given,
                        hbil_config *own);
hbil_status frame_take(hbil_context *context, const hbil_frame *given,
                       hbil_frame *own);

/* hbil_model.relative_thickness of HBIL_MODEL_DEFAULT. */
#define DEFAULT_RELATIVE_THICKNESS 0.06f

/* The enumerator, for messages about settings that were accepted. */
const char *cache_method_name(hbil_cache_method method);

/* Whether the light of any sample may be rejected because it faces away. */
bool config_rejects_back_faces(const hbil_config *config);

/* Whether occluders have a finite thickness. */
bool config_has_thickness(const hbil_config *config);

#endif
