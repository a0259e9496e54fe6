/* The planes of a G-buffer and of a plan's outputs, each in one row of a list
 * that the library and the tests share.
 */
#ifndef HBIL_PLANE_LIST_H
#define HBIL_PLANE_LIST_H

/* ROW(id, group, field, channels) for each: PLANE_id, also the prefix of its
 * build defines; the group and the member of hbil_config, and the member of
 * hbil_frame; its channels, for normals those of HBIL_NORMAL_XYZ.  Inputs are
 * first. */
#define PLANE_LIST(ROW)                                                        \
  ROW(DEPTH, inputs, depth, 1)                                                 \
  ROW(NORMAL, inputs, normal, 3)                                               \
  ROW(ALBEDO, inputs, albedo, 3)                                               \
  ROW(F0, inputs, f0, 3)                                                       \
  ROW(DIRECT, inputs, direct, 3)                                               \
  ROW(EMISSION, inputs, emission, 3)                                           \
  ROW(MOTION, inputs, motion, 2)                                               \
  ROW(NEAR, outputs, near_irradiance, 3)                                       \
  ROW(FAR, outputs, far_irradiance, 3)                                         \
  ROW(AO, outputs, ao, 1)                                                      \
  ROW(BENT, outputs, bent_normal, 3)                                           \
  ROW(CONE, outputs, cone_cosine, 1)                                           \
  ROW(INDIRECT, outputs, indirect, 3)                                          \
  ROW(BEAUTY, outputs, beauty, 3)                                              \
  ROW(ERROR, outputs, error_estimate, 2)                                       \
  ROW(UNKNOWN, outputs, unknown, 1)                                            \
  ROW(GLOSSY, outputs, glossy, 3)

#define PLANE_ID(id, group, field, channels) PLANE_##id,
typedef enum plane_id {
  PLANE_LIST(PLANE_ID) PLANE_COUNT,
  PLANE_FIRST_OUTPUT = PLANE_NEAR
} plane_id;
#undef PLANE_ID

#endif
