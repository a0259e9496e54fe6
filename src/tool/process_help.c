/* The help text of `hbil process`.  Defaults come from the library. */
#include "tool/process_help.h"

#include "tool/settings.h"
#include "tool/source_arguments.h"

#include <stdio.h>

static void print_files(void) {
  puts(
      "usage: hbil process [options] -o DIR FRAME.exr...\n"
      "\n"
      "Computes the indirect light of a sequence's frames, in order; each\n"
      "frame hands its light on to the next.  Writes DIR/FRAME.exr.  Reads\n"
      "the multi-layer files of renderers (see --source) and those of hbil\n"
      "demo.  FRAME.exr may be a pattern such as shot.%04d.exr or\n"
      "shot.####.exr, or a folder that holds the EXR files of one sequence.\n"
      "\n"
      "  -o, --output DIR      folder of the results; it is made if it is "
      "missing\n"
      "  --frames RANGES       numbers for the patterns, such as 1-240x2,300\n"
      "                        (all that exist)\n"
      "  --pre-roll N          light as many as N frames before the first of\n"
      "                        --frames, for the light that they hand on, and\n"
      "                        write none of them: for chunks of a sequence "
      "(0)\n"
      "  --decide-by FRAME.exr the frame whose pixels decide what no option "
      "says\n"
      "                        (far light, emission, kinds of depth and "
      "normals):\n"
      "                        the same one for all chunks (the first frame)\n"
      "  --layers LIST         of near_irradiance, far_irradiance, indirect,\n"
      "                        ao, bent_normal, cone_cosine, beauty, unknown,\n"
      "                        glossy, error_estimate (all that the mode has,\n"
      "                        without the last three)\n"
      "  --copy-channels       also put the frame's own channels into its\n"
      "                        result\n"
      "  --compression NAME    none, rle, zips, zip, piz, pxr24, b44, b44a,\n"
      "                        dwaa, dwab, or input for that of the frame\n"
      "                        (none, which is written fastest)\n"
      "  --half                store the layers as half floats\n"
      "  --camera FILE         JSON camera of all frames (FRAME.json beside\n"
      "                        each FRAME.exr, or else the header's, or else\n"
      "                        one that fits the positions, as `positions`\n"
      "                        in place of FILE)\n"
      "  --environment R,G,B   far light, the same from everywhere\n"
      "  --environment FILE    far light, a latitude-longitude map\n"
      "  --environment none|frame\n"
      "                        no far light, or the mean radiance of the\n"
      "                        frame's own surfaces (chosen by the sky and "
      "the\n"
      "                        direct light of the first frame)");
}

static void print_running(void) {
  puts(
      "  --device NAME         index or part of a name, see hbil devices (the\n"
      "                        first GPU, or else the first device)\n"
      "  --overwrite           replace files that exist already, but none "
      "that\n"
      "                        the job reads; without it they are an error\n"
      "  --resume              continue an interrupted job: results in DIR\n"
      "                        that were made from the same frames, settings,\n"
      "                        device and version stay; the others get the "
      "same\n"
      "                        bits as without the interruption.  Replaces\n"
      "                        only files that hbil wrote\n"
      "  --dry-run             check everything, print what would be written,\n"
      "                        and write nothing\n"
      "  --repeat N            run every frame N times, for more bounces (1)\n"
      "  --warm-up N           run the first frame N more times (3)\n"
      "  --horizon-cache MIB   memory for caching horizons between runs of "
      "the\n"
      "                        same frame.  Makes the third and later runs\n"
      "                        faster and doesn't change the result (1024, or\n"
      "                        a quarter of the device's memory, when a frame\n"
      "                        runs eight times or more; otherwise, and where\n"
      "                        ulimit limits memory, 0)\n"
      "  --preview             also write DIR/FRAME.LAYER.png\n"
      "  --contact-sheet PNG   layers side by side, with at most eight frames\n"
      "                        of the sequence below each other, and what the\n"
      "                        radiance cache knows; replaces only pictures "
      "that\n"
      "                        hbil wrote\n"
      "  --timings             print milliseconds per pass and frame (of the\n"
      "                        last run of each frame), what was skipped, and\n"
      "                        where the time of the whole job went.\n"
      "                        A CPU device shares its cores with reading and\n"
      "                        writing (hbil-bench measures passes alone)\n"
      "  --json                print the timings as JSON\n"
      "  --quiet               print no line per frame and no progress");
}

static void print_cache(void) {
  hbil_cache_config defaults;
  hbil_cache_config_init(&defaults);
  puts(
      "\n"
      "What the frames don't show: a radiance cache in world space holds what\n"
      "views of the place have shown, and lights the directions that a frame\n"
      "leaves open.  There is one if the camera moves between frames, which\n"
      "are then views for those behind them, or if one of the first six\n"
      "options asks for it.  --model paper has one only if an option asks.\n"
      "--far environment, --far none, --quality reference and modes other\n"
      "than hbil have none.\n"
      "\n"
      "Radiance cache:\n"
      "  --view FILE.exr       a picture of the same place, with depth,\n"
      "                        normals, direct light and a camera of its own,\n"
      "                        of any size and projection, by the renderer of\n"
      "                        the frames.  The cache sees it before the "
      "first\n"
      "                        frame.  FILE.exr may be a pattern, or\n"
      "                        have wildcards ('views/*.exr'); the option\n"
      "                        may be given again\n"
      "  --learn               the cache sees all frames before the first one\n"
      "                        is lit, so each is lit by all; without it, by\n"
      "                        those before it.  Reads every frame twice\n"
      "  --cache-load FILE     begin with the cache in a file of "
      "--cache-save,\n"
      "                        which also says its size and place\n"
      "  --cache-fixed         the frames don't change the loaded cache, so "
      "that\n"
      "                        each is lit by it alone, whatever came before\n"
      "  --cache-save FILE     write the cache to a file at the end; replaces\n"
      "                        only caches\n"
      "  --far rays|cones|lpv|rsm|environment|none\n"
      "                        where light from beyond the near field comes\n"
      "                        from.  From the cache: by rays (the default\n"
      "                        and the most accurate), by cones, or by light\n"
      "                        propagation volumes.  In place of the cache:\n"
      "                        from reflective shadow maps, which are the\n"
      "                        views of lights.  Without either: as\n"
      "                        --environment says, or none at all\n"
      "  --light-view FILE.exr\n"
      "                        with --far rsm: a picture as for --view, from\n"
      "                        where a light is, with the direct light of\n"
      "                        that light alone; up to four, or a pattern\n"
      "  --view-light direct|radiance\n"
      "                        what views hold: direct light, to which the\n"
      "                        cache adds the bounces, or also indirect "
      "light\n"
      "                        (Blender's DiffInd), which is the radiance of\n"
      "                        surfaces after all bounces (direct)");
  printf("  --cache-size N        voxels across each of its %u levels, 16, 32, "
         "64,\n"
         "                        128 or 256; twice as many take eight times "
         "the\n"
         "                        memory (%u)\n",
         (unsigned)defaults.levels, (unsigned)defaults.voxels);
}

static void print_quality(const hbil_config *defaults) {
  puts(
      "\n"
      "How well:\n"
      "  --quality fast|balanced|high\n"
      "                        sets slices, steps per side, step growth,\n"
      "                        resolution, sample grid, filter and storage;\n"
      "                        options behind it overrule it\n"
      "  --quality reference   the exact screen-space integral of the same\n"
      "                        model, in double precision, on all CPUs and\n"
      "                        without OpenCL: looks at every pixel that a\n"
      "                        slice crosses, with --slices 1..4096 (256).\n"
      "                        Takes minutes to hours; compare with it to see\n"
      "                        the sampling error");
  printf(
      "  --slices N            slices per pixel, 1..32 (%u)\n"
      "  --steps-per-side N    samples on each side of a slice, 1..256 (%u)\n"
      "  --step-growth G       0: equal steps; otherwise the last step is\n"
      "                        (1+G)^2 times the first (%g)\n",
      defaults->sampling.slices, defaults->sampling.steps_per_side,
      (double)defaults->sampling.step_growth);
  puts(
      "  --sample-grid full-resolution|same-layer\n"
      "                        where samples may lie: any pixel, or every\n"
      "                        fourth (full-resolution)\n"
      "  --resolution auto|full|half\n"
      "                        pixels that are computed: all, or every second\n"
      "                        one in x and y, and the others are filled in\n"
      "                        from neighbours on the same surface; auto: "
      "half\n"
      "                        for pictures of 400000 pixels and more (auto)\n"
      "  --extrapolate yes|no  find what lies between the samples (yes)\n"
      "  --no-skip             do all work, even if it cannot change the\n"
      "                        result, but for roundings after 32 runs of the\n"
      "                        same frame (see --timings)\n"
      "  --storage packed|float32\n"
      "                        precision of the planes between the passes\n"
      "                        (packed)\n"
      "  --unfiltered          only undo the 4x4 interleaving, without the\n"
      "                        filter; not with --resolution half; auto is "
      "full\n"
      "                        then\n"
      "  --max-history-frames N\n"
      "                        average the last N frames, each sampled with a\n"
      "                        rotated pattern, which reduces noise.  Use 2 "
      "to\n"
      "                        4 for moving cameras and 8 or more for still\n"
      "                        ones; 0..1024 (0: off)");
}

static void print_model(const hbil_config *defaults) {
  hbil_model world = defaults->model;
  hbil_model_set(&world, HBIL_MODEL_WORLD);
  puts("\n"
       "The method:\n"
       "  --model default|paper everything below that isn't given: hbil's own\n"
       "                        model, or that of the paper (Mayaux 2018): "
       "infinite\n"
       "                        thickness, facing fade -0.1,0, the last "
       "accepted\n"
       "                        sample's light in place of back-facing ones, "
       "no\n"
       "                        far light, radiance as feedback, no\n"
       "                        extrapolation, 2 slices, 8 steps per side,\n"
       "                        full resolution, no warm-up;\n"
       "                        options behind it overrule it (default)\n"
       "  --mode hbil|gtao|hbao near light and occlusion; cosine-weighted\n"
       "                        occlusion and bent normal (all layers but\n"
       "                        near_irradiance); uniform occlusion with "
       "falloff\n"
       "                        (ao, far_irradiance, indirect, beauty) (hbil)\n"
       "  --falloff linear|soft|none\n"
       "                        weight of an occluder at distance r within\n"
       "                        radius R, for hbao: 1-r/R, 1-r/(3R), 1 "
       "(linear)");
  printf("  --radius R            world units, or inf (%g; with a radiance\n"
         "                        cache, %g of its voxels)\n"
         "  --thickness T         of occluders, world units (inf)\n"
         "  --relative-thickness T\n"
         "                        the same as a share of their depth, or of\n"
         "                        an orthographic picture's width (%g; with a\n"
         "                        radiance cache, %g)\n"
         "  --facing-fade A,B     cosines between which the light of a sample\n"
         "                        fades in (%g,%g)\n",
         (double)defaults->model.radius, HBIL_CACHE_NEAR_VOXELS,
         (double)defaults->model.relative_thickness,
         (double)world.relative_thickness,
         (double)defaults->model.facing_fade[0],
         (double)defaults->model.facing_fade[1]);
  puts(
      "  --back-facing-fallback last-accepted|black|frame-mean\n"
      "                        light of samples that face away: that of the\n"
      "                        last sample before, none, or the mean radiance\n"
      "                        of the frame (frame-mean)\n"
      "  --unseen-light SHARE  radiance of surfaces outside the picture, over "
      "that\n"
      "                        of those in it, 0..1, where light is guessed "
      "from\n"
      "                        the frame (0.76)\n"
      "  --roughness R         of the layer glossy, as Blender has it, 0.3..1\n"
      "                        (0.5)\n"
      "  --gather-emission yes|no\n"
      "                        emission lights neighbours, too (yes if the\n"
      "                        first frame's direct light cannot contain what\n"
      "                        its lamps emit)\n"
      "  --reprojection none|camera|motion\n"
      "                        how light is carried to the next frame: not at\n"
      "                        all, by the camera's movement, by motion "
      "vectors\n"
      "                        (camera)");
  printf("  --disocclusion-threshold S\n"
         "                        drop carried light if its depth differs by\n"
         "                        more than this share of the depth, or of an\n"
         "                        orthographic picture's width (%g)\n",
         (double)defaults->history.disocclusion_threshold);
}

void process_help(void) {
  process_settings defaults;
  process_settings_init(&defaults);
  print_files();
  print_running();
  print_cache();
  print_quality(&defaults.config);
  print_model(&defaults.config);
  source_usage();
  puts(
      "\n"
      "Layers: near_irradiance, far_irradiance: E_near, E_far; indirect:\n"
      "(1-F0)(E_near+E_far)/pi, which renderers call diffuse indirect, "
      "without\n"
      "albedo; ao.V: 1 open, 0 closed; bent_normal: unit vector, world space;\n"
      "cone_cosine.V: cosine of the bent cone's half-angle; beauty: the final\n"
      "picture; unknown.V: the share of what a surface sees whose light is a\n"
      "guess, because the frame doesn't show it; glossy: light that a rough\n"
      "mirror reflects, without its colour; error_estimate: how far ao\n"
      "(X) and near_irradiance (Y) of 95 % of the pixels may be off because\n"
      "samples are few.\n"
      "\n"
      "At the end, lines on standard error tell the mean of `unknown` over "
      "all\n"
      "surfaces, with a warning if most of the light is a guess, and which\n"
      "stage limited the job; --quiet leaves them out.");
}
