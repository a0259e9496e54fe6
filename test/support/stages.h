/*
 * What passes hand to each other: a plan's buffers, read and written as planes
 * in full resolution.
 */
#ifndef HBIL_TEST_STAGES_H
#define HBIL_TEST_STAGES_H

#include "hbil/hbil_stages.h"

#include "test/support/fixture.h"

/* Reads a stage.  Packed words are decoded: the planes are those of
 * HBIL_STORAGE_FLOAT32, whatever the plan's storage.  Those of glossy light and
 * of errors are where exact/glossy.h has them.  In GATHERED, pixels that the
 * settings leave out are 0.  Stages of a search of their own (AO_) need a setup
 * whose configuration is that search's (exact_searches_ao()). */
exact_planes stage_read(setup *s, hbil_stage stage);
/* Whether the plan has that stage, and that plane in it. */
bool stage_has(setup *s, hbil_stage stage, int plane);
/* Writes a stage and leaves its padding alone; packed storage is encoded.
 * Planes that the plan doesn't have are ignored. */
void stage_write(setup *s, hbil_stage stage, const exact_planes *planes);

/* Whether the plan gathers light; if not, its planes of E_near are undefined.
 */
bool gathers_light(const setup *s);

/* Runs split and gather, and reads HBIL_STAGE_GATHERED. */
exact_planes stage_gathered(setup *s);
/* The mean of HBIL_STAGE_GATHERED over frames with index 0 to frames - 1.  Each
 * index rotates the pattern: the mean has `frames` times as many slices as the
 * plan, which has 32 at most. */
exact_planes stage_gathered_mean(setup *s, int frames);

/* What the exact passes make of the setup's inputs: SPLIT without history, and
 * GATHERED with the plan's samples or densely. */
exact_planes expected_split(const setup *s);
exact_planes expected_gathered(const setup *s);
exact_planes expected_gathered_densely(const setup *s, const exact_dense *how);

#endif
