/*
 * Conventions: what the numbers in a dump mean.  Renderers differ in what they
 * call depth, in the space and encoding of normals, and in what direct light is
 * divided by.
 *
 * Camera space here is OpenGL's: x right, y up, looking along -z.  View space
 * is the library's: x right, y down, z forward (hbil.h).
 */
#ifndef HBIL_DUMP_CONVENTIONS_H
#define HBIL_DUMP_CONVENTIONS_H

typedef enum depth_kind {
  DEPTH_PLANAR = 0, /* distance along the camera's axis */
  DEPTH_RAY,        /* distance from the eye */
  DEPTH_POSITION,   /* computed from the positions */
  DEPTH_DEVICE,     /* 0 at the near plane, 1 at the far plane */
  DEPTH_REVERSED    /* 1 at the near plane, 0 at the far plane */
} depth_kind;

/* The words of --depth, in the order of depth_kind; ends with NULL. */
extern const char *const depth_words[];

typedef enum dump_space { SPACE_WORLD = 0, SPACE_CAMERA } dump_space;

/* The words of --normals and --positions, in the order of dump_space; ends with
 * NULL. */
extern const char *const space_words[];

typedef enum direct_kind {
  DIRECT_IRRADIANCE = 0,
  DIRECT_LIGHT,   /* irradiance / pi: the radiance of a white surface */
  DIRECT_RADIANCE /* irradiance * albedo / pi */
} direct_kind;

/* The words of --direct, in the order of direct_kind; ends with NULL. */
extern const char *const direct_words[];

/* What a source leaves open and the pixels of the first frame may decide (see
 * settle.h).  A bit mask. */
enum {
  UNSURE_DEPTH = 1,   /* whether depth is planar or along the ray */
  UNSURE_NORMALS = 2, /* whether normals are encoded, and in which space */
  UNSURE_SKY = 4,     /* which depth stands for the sky */
  UNSURE_LAMPS = 8    /* from which radiance on pixels show lamps */
};

typedef struct conventions {
  depth_kind depth;
  dump_space normals, positions;
  direct_kind direct;
  int backwards;     /* 1: depths are negative */
  int from_near;     /* 1: distances along the ray begin at the near plane */
  int encoded;       /* 1: normals are stored as (n + 1) / 2 */
  int from_depth;    /* 1: normals are not read; depth tells them */
  int premultiplied; /* 1: depth, normals, positions, albedo and light are
                        multiplied with the coverage */
  int shows_sources; /* 1: direct light also shows lamps and the sky, which
                        are taken out of it (light_sources.h) */
  int clips;      /* 1: nothing beyond the far plane is shown, and the sky may
                     lie there */
  unsigned flips; /* axes of normals and positions whose sign changes: 1 x, 2 y,
                     4 z */
  unsigned unsure;
  float sky_depth;  /* depths from here on are sky; infinity: none */
  float lamps_from; /* radiance over albedo from which on a pixel shows a lamp;
                       0: not known to show any */
  float motion_scale[2], motion_zero; /* pixels = (value - zero) * scale */
  double unit;      /* camera units in one unit of depth and position */
  double near, far; /* clipping planes, camera units; 0: unknown */
} conventions;

/* Whether depths are planar, in camera units, so that nothing but sky_depth
 * needs to be known of them. */
int conventions_depth_is_planar(const conventions *how);

/* Whether distances along the ray begin at a near plane that is known. */
int conventions_begin_at_near(const conventions *how);

/* The conventions under which conversion changes nothing: values are read as
 * they are stored. */
conventions conventions_as_stored(void);

#endif
