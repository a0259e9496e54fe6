/*
 * The table of sources.
 *
 * A row describes a program's default settings.  What users commonly change
 * there is marked as unsure and decided by the first frame's pixels (settle.c).
 */
#include "dump/source.h"

#include <math.h>
#include <string.h>

/* Blender puts the name of the view layer in front: "ViewLayer.Depth.Z".  Names
 * up to Blender 4 stand before those of Blender 5. */
static const pass_name cycles_passes[] = {
    {ROLE_DEPTH, "Depth"},      {ROLE_NORMAL, "Normal"},
    {ROLE_ALBEDO, "DiffCol"},   {ROLE_ALBEDO, "Diffuse Color"},
    {ROLE_DIRECT, "DiffDir"},   {ROLE_DIRECT, "Diffuse Direct"},
    {ROLE_EMISSION, "Emit"},    {ROLE_EMISSION, "Emission"},
    {ROLE_BACKGROUND, "Env"},   {ROLE_BACKGROUND, "Environment"},
    {ROLE_MOTION, "Vector"},    {ROLE_POSITION, "Position"},
    {ROLE_INDIRECT, "DiffInd"}, {ROLE_INDIRECT, "Diffuse Indirect"},
    {ROLE_PICTURE, "Combined"}, {ROLE_ALPHA, "Combined"},
    {ROLE_COUNT, NULL},
};

/* hbil's own names come first. */
static const pass_name plain_passes[] = {
    {ROLE_DEPTH, "depth"},       {ROLE_NORMAL, "normal"},
    {ROLE_ALBEDO, "albedo"},     {ROLE_DIRECT, "direct"},
    {ROLE_EMISSION, "emission"}, {ROLE_MOTION, "motion"},
    {ROLE_POSITION, "position"}, {ROLE_DEPTH, "Depth"},
    {ROLE_DEPTH, "Z"},           {ROLE_DEPTH, "z"},
    {ROLE_DEPTH, "zdepth"},      {ROLE_NORMAL, "Normal"},
    {ROLE_NORMAL, "normals"},    {ROLE_NORMAL, "Normals"},
    {ROLE_NORMAL, "N"},          {ROLE_NORMAL, "n"},
    {ROLE_ALBEDO, "Albedo"},     {ROLE_ALBEDO, "diffuse_albedo"},
    {ROLE_ALBEDO, "basecolor"},  {ROLE_ALBEDO, "BaseColor"},
    {ROLE_DIRECT, "Direct"},     {ROLE_EMISSION, "Emission"},
    {ROLE_EMISSION, "emissive"}, {ROLE_BACKGROUND, "background"},
    {ROLE_MOTION, "Motion"},     {ROLE_MOTION, "velocity"},
    {ROLE_POSITION, "Position"}, {ROLE_POSITION, "P"},
    {ROLE_INDIRECT, "indirect"}, {ROLE_PICTURE, "picture"},
    {ROLE_ALPHA, "picture"},     {ROLE_COUNT, NULL},
};

/* Ns is the shading normal, N the geometric normal. */
static const pass_name pbrt_passes[] = {
    {ROLE_POSITION, "P"}, {ROLE_NORMAL, "Ns"},     {ROLE_NORMAL, "N"},
    {ROLE_DEPTH, "P"},    {ROLE_ALBEDO, "Albedo"}, {ROLE_COUNT, NULL},
};

/* Users choose the names.  These are the manual's and common ones.  Colours
 * without a layer, and those of a layer with alpha, are the picture of the
 * integrator that `aov` is put around. */
static const pass_name mitsuba_passes[] = {
    {ROLE_DEPTH, "*.T"},         {ROLE_NORMAL, "sh_normal"},
    {ROLE_NORMAL, "nn"},         {ROLE_NORMAL, "normal"},
    {ROLE_NORMAL, "normals"},    {ROLE_NORMAL, "n"},
    {ROLE_NORMAL, "geo_normal"}, {ROLE_POSITION, "position"},
    {ROLE_POSITION, "pos"},      {ROLE_POSITION, "pp"},
    {ROLE_POSITION, "p"},        {ROLE_ALBEDO, "albedo"},
    {ROLE_ALBEDO, "alb"},        {ROLE_DIRECT, ""},
    {ROLE_DIRECT, "*RGBA"},      {ROLE_COVERAGE, "A"},
    {ROLE_COVERAGE, "*.A"},      {ROLE_COUNT, NULL},
};

/* The types of the film's outputs, after which their files are named. */
static const pass_name luxcore_passes[] = {
    {ROLE_DEPTH, "DEPTH"},
    {ROLE_NORMAL, "SHADING_NORMAL"},
    {ROLE_NORMAL, "AVG_SHADING_NORMAL"},
    {ROLE_NORMAL, "GEOMETRY_NORMAL"},
    {ROLE_ALBEDO, "ALBEDO"},
    {ROLE_DIRECT, "DIRECT_DIFFUSE"},
    {ROLE_DIRECT, "DIRECT_DIFFUSE_REFLECT"},
    {ROLE_EMISSION, "EMISSION"},
    {ROLE_POSITION, "POSITION"},
    {ROLE_INDIRECT, "INDIRECT_DIFFUSE"},
    {ROLE_INDIRECT, "INDIRECT_DIFFUSE_REFLECT"},
    {ROLE_COUNT, NULL},
};

static const pass_name arnold_passes[] = {
    {ROLE_DEPTH, "Z"},
    {ROLE_NORMAL, "N"},
    {ROLE_POSITION, "P"},
    {ROLE_ALBEDO, "diffuse_albedo"},
    {ROLE_ALBEDO, "albedo"},
    {ROLE_DIRECT, "diffuse_direct"},
    {ROLE_EMISSION, "emission"},
    {ROLE_BACKGROUND, "background"},
    {ROLE_MOTION, "motionvector"},
    {ROLE_INDIRECT, "diffuse_indirect"},
    {ROLE_PICTURE, ""},
    {ROLE_ALPHA, ""},
    {ROLE_COUNT, NULL},
};

static const pass_name vray_passes[] = {
    {ROLE_DEPTH, "VRayZDepth"},
    {ROLE_DEPTH, "zDepth"},
    {ROLE_DEPTH, "ZDepth"},
    {ROLE_DEPTH, "Z"},
    {ROLE_DEPTH, "depth"},
    {ROLE_NORMAL, "bump_normals"},
    {ROLE_NORMAL, "VRayBumpNormals"},
    {ROLE_NORMAL, "normals"},
    {ROLE_NORMAL, "VRayNormals"},
    {ROLE_ALBEDO, "diffuse"},
    {ROLE_ALBEDO, "VRayDiffuseFilter"},
    {ROLE_ALBEDO, "diffuseFilter"},
    {ROLE_DIRECT, "lighting"},
    {ROLE_DIRECT, "VRayLighting"},
    {ROLE_EMISSION, "selfIllum"},
    {ROLE_EMISSION, "VRaySelfIllumination"},
    {ROLE_BACKGROUND, "background"},
    {ROLE_BACKGROUND, "VRayBackground"},
    {ROLE_MOTION, "velocity"},
    {ROLE_MOTION, "VRayVelocity"},
    {ROLE_INDIRECT, "GI"},
    {ROLE_INDIRECT, "VRayGlobalIllumination"},
    {ROLE_PICTURE, ""},
    {ROLE_ALPHA, ""},
    {ROLE_COUNT, NULL},
};

static const pass_name renderman_passes[] = {
    {ROLE_DEPTH, "z"},
    {ROLE_DEPTH, "__depth"},
    {ROLE_NORMAL, "__Nworld"},
    {ROLE_POSITION, "__Pworld"},
    {ROLE_ALBEDO, "albedo"},
    {ROLE_DIRECT, "directDiffuse"},
    {ROLE_EMISSION, "emissive"},
    {ROLE_MOTION, "motionBack"},
    {ROLE_INDIRECT, "indirectDiffuse"},
    {ROLE_PICTURE, ""},
    {ROLE_ALPHA, ""},
    {ROLE_COUNT, NULL},
};

static const pass_name unreal_passes[] = {
    {ROLE_DEPTH, "FinalImageMovieRenderQueue_WorldDepth"},
    {ROLE_NORMAL, "FinalImageMovieRenderQueue_WorldNormal"},
    {ROLE_NORMAL, "FinalImageMovieRenderQueue_Normal"},
    {ROLE_ALBEDO, "FinalImageMovieRenderQueue_BaseColor"},
    {ROLE_MOTION, "FinalImageMovieRenderQueue_MotionVectors"},
    {ROLE_COUNT, NULL},
};

static const char *const blender_marks[] = {"Blender", NULL};

static const char *const pbrt_marks[] = {"dzdx", "Ns.X", NULL};

static const char *const mitsuba_marks[] = {"Mitsuba", "sh_normal", NULL};

static const char *const arnold_marks[] = {"arnold", "Arnold", "motionvector",
                                           "diffuse_albedo", NULL};

static const char *const vray_marks[] = {"VRay", "V-Ray", "vray",
                                         "bump_normals", NULL};

static const char *const renderman_marks[] = {
    "RenderMan", "renderman", "__Nworld", "directDiffuse", NULL};

static const char *const unreal_marks[] = {"MovieRenderQueue", "unreal", NULL};

#define ALWAYS .unit = 1.0, .sky_depth = INFINITY
#define UNSURE_ALL (UNSURE_DEPTH | UNSURE_NORMALS | UNSURE_SKY)

const source_info source_table[DUMP_KINDS] = {
    [DUMP_PLAIN] = {"generic",
                    "hbil's own channels",
                    plain_passes,
                    NULL,
                    0,
                    {ALWAYS, .motion_scale = {1, 1}, .unsure = UNSURE_ALL}},
    /* Depth is 1e10 where there is nothing; in EEVEE it is the far plane's.
     * DiffDir is irradiance divided by pi.  The y of Vector points up. */
    [DUMP_CYCLES] = {"blender",
                     "Blender Cycles passes",
                     cycles_passes,
                     blender_marks,
                     0,
                     {.unit = 1.0,
                      .sky_depth = 1e9f,
                      .clips = 1,
                      .direct = DIRECT_LIGHT,
                      .motion_scale = {1, -1}}},
    [DUMP_PBRT] = {"pbrt",
                   "pbrt's gbuffer film",
                   pbrt_passes,
                   pbrt_marks,
                   0,
                   {ALWAYS, .depth = DEPTH_POSITION, .normals = SPACE_CAMERA,
                    .positions = SPACE_CAMERA, .flips = 4}},
    [DUMP_MITSUBA] = {"mitsuba",
                      "Mitsuba's aov integrator",
                      mitsuba_passes,
                      mitsuba_marks,
                      0,
                      {ALWAYS, .depth = DEPTH_RAY, .from_near = 1,
                       .direct = DIRECT_RADIANCE, .premultiplied = 1,
                       .shows_sources = 1, .unsure = UNSURE_LAMPS}},
    /* Depth is infinite where there is nothing. */
    [DUMP_LUXCORE] = {"luxcore",
                      "LuxCore's film outputs",
                      luxcore_passes,
                      NULL,
                      1,
                      {ALWAYS, .depth = DEPTH_RAY, .direct = DIRECT_RADIANCE}},
    [DUMP_ARNOLD] = {"arnold",
                     "Arnold's AOVs",
                     arnold_passes,
                     arnold_marks,
                     0,
                     {ALWAYS, .direct = DIRECT_RADIANCE,
                      .unsure = UNSURE_DEPTH | UNSURE_SKY}},
    [DUMP_VRAY] = {"vray",
                   "V-Ray's render elements",
                   vray_passes,
                   vray_marks,
                   0,
                   {ALWAYS, .normals = SPACE_CAMERA, .direct = DIRECT_RADIANCE,
                    .unsure = UNSURE_SKY}},
    [DUMP_RENDERMAN] = {"renderman",
                        "RenderMan's AOVs",
                        renderman_passes,
                        renderman_marks,
                        0,
                        {ALWAYS, .direct = DIRECT_RADIANCE,
                         .unsure = UNSURE_DEPTH | UNSURE_SKY}},
    [DUMP_UNREAL] = {"unreal",
                     "Unreal's Movie Render Queue",
                     unreal_passes,
                     unreal_marks,
                     0,
                     {ALWAYS, .motion_zero = 0.5f,
                      .unsure = UNSURE_NORMALS | UNSURE_SKY}},
};

const char *const source_words[] = {"generic", "blender", "pbrt", "mitsuba",
                                    "luxcore", "arnold",  "vray", "renderman",
                                    "unreal",  "auto",    NULL};

void source_options_init(source_options *options) {
  memset(options, 0, sizeof *options);
  options->source = options->depth = options->normals = options->encoded =
      options->positions = options->direct = options->gamma = -1;
  options->sky_depth = NAN;
}

conventions source_conventions(dump_kind kind, const source_options *o) {
  conventions how = source_table[kind].how;
  if (o->depth >= 0) {
    how.depth = (depth_kind)o->depth;
    how.unsure &= ~(unsigned)UNSURE_DEPTH;
  }
  if (o->normals >= 0) {
    /* the flips of the row belong to the row's space */
    if (how.normals != (dump_space)o->normals)
      how.flips = 0;
    how.normals = (dump_space)o->normals;
  }
  if (o->positions >= 0)
    how.positions = (dump_space)o->positions;
  if (o->encoded >= 0) {
    how.encoded = o->encoded;
    how.unsure &= ~(unsigned)UNSURE_NORMALS;
  }
  how.from_depth = o->from_depth;
  if (o->from_depth) /* normals also decide which kind of depth there is */
    how.unsure &= ~(unsigned)(UNSURE_NORMALS | UNSURE_DEPTH);
  if (o->direct >= 0)
    how.direct = (direct_kind)o->direct;
  how.flips ^= o->flips;
  if (o->unit > 0.0f)
    how.unit = (double)o->unit;
  if (!isnan(o->sky_depth)) {
    how.sky_depth = o->sky_depth != 0.0f ? fabsf(o->sky_depth) : INFINITY;
    how.clips = 0;
    how.unsure &= ~(unsigned)UNSURE_SKY;
  }
  how.near = (double)o->clip[0];
  how.far = (double)o->clip[1];
  if (o->motion_scale[0] != 0.0f)
    memcpy(how.motion_scale, o->motion_scale, sizeof how.motion_scale);
  return how;
}
