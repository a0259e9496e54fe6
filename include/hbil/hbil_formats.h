/*
 * hbil: formats, that is, how the pixels of a plane lie in memory.  Programs
 * include hbil/hbil.h.
 */
#ifndef HBIL_HBIL_FORMATS_H
#define HBIL_HBIL_FORMATS_H

#include <hbil/hbil_base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ------------------------------------------------------------------------ */
/* Formats: how the pixels of a plane lie in memory                          */

/* What a component is.  Kernels read every format directly, without a copy,
 * except for images.  The colours are albedo, f0, direct and emission.  What
 * depends on the plane is beside its member in hbil_inputs.  All colours are
 * linear light but for HBIL_SRGB8.  All bytes are in the device's order. */
typedef enum hbil_component {
  HBIL_NONE = 0,    /* the plane does not exist */
  HBIL_FLOAT32 = 1, /* 4 bytes; all inputs and outputs */
  HBIL_FLOAT16 = 2, /* 2 bytes, IEEE half; all inputs and outputs */
  /* 1 byte, 0..255 for 0..1; normals, and colours that are linear.  Textures of
   * albedo mostly are not: those are HBIL_SRGB8. */
  HBIL_UNORM8 = 3,
  /* 2 bytes, 0..65535 for 0..1; colours, normals, hardware depth */
  HBIL_UNORM16 = 4,
  /* 1 byte, -127..127 for -1..1, and -128 is -1, too; normals */
  HBIL_SNORM8 = 5,
  /* 2 bytes, -32767..32767 for -1..1, and -32768 is -1, too; normals, motion */
  HBIL_SNORM16 = 6,
  /* The low 24 bits of a word of 32 bits, for 0..1; hardware depth.  The high 8
   * bits may hold anything, such as a stencil: D24_UNORM_S8_UINT of DXGI and
   * Vulkan, X8_D24_UNORM_PACK32.  GL_UNSIGNED_INT_24_8 has the stencil in the
   * low bits and can't be read. */
  HBIL_UNORM24 = 7,
  /* Words of 32 bits that hold all channels of a pixel.
   * 3 x 10 bits, red lowest, for 0..1, and 2 more that are not read;
   * A2B10G10R10 in Vulkan; colours, HBIL_NORMAL_XYZ */
  HBIL_RGB10A2_UNORM = 8,
  /* Floats without a sign, 11, 11 and 10 bits, red lowest, up to 65024 and
   * 64512; 6 and 5 bits of mantissa; B10G11R11 in Vulkan; colours */
  HBIL_R11G11B10_FLOAT = 9,
  /* 3 mantissas of 9 bits, red lowest, and the exponent that they share in the
   * highest 5 bits: a channel is mantissa 2^(exponent - 24), up to 65408;
   * E5B9G9R9 in Vulkan; colours */
  HBIL_RGB9E5_FLOAT = 10,
  /* The plane is an image2d_t of the frame's size; all inputs and outputs.
   * hbil_plane.buffer is the image.  The plan copies it from or to planes of
   * floats of its own (HBIL_PASS_IMPORT, HBIL_PASS_EXPORT), so it takes as much
   * memory as HBIL_FLOAT32, and a little time.  The image has the plane's
   * channels or more, from red on, and the type UNORM, SNORM, HALF_FLOAT or
   * FLOAT; depth has HALF_FLOAT, FLOAT or, if it is hardware depth,
   * UNORM_INT16.  Normals and bent normals in a UNORM image are (n+1)/2.
   * Channels that an output does not have become 0, and alpha becomes 1.  If
   * an output is an image and light is carried over, the plan has memory for
   * the light of two frames. */
  HBIL_IMAGE = 11,
  /* 1 byte, 0..255 for 0..1 with the curve of sRGB (IEC 61966-2-1), decoded to
   * linear light to 1e-6 of it: R8G8B8A8_SRGB of DXGI and Vulkan,
   * GL_SRGB8_ALPHA8; colours */
  HBIL_SRGB8 = 12
} hbil_component;

/* How the pixels of a plane lie in its buffer.  The formats are fixed per plan,
 * because the kernels are compiled for them.
 * pixel_pitch is the distance from a pixel to its right-hand neighbour, in
 * bytes, a multiple of the component's size.  The size of one component means
 * planar: each channel is an image of its own.  The size of all channels or
 * more, up to 64 components, means interleaved: the channels of a pixel are
 * adjacent, and further bytes are neither read nor changed.  0 means the size
 * of all channels.  A word that holds all channels counts as one component of
 * one channel.  HBIL_IMAGE ignores it. */
typedef struct hbil_plane_format {
  hbil_component component;
  cl_uint pixel_pitch;
} hbil_plane_format;

/* What the input `depth` holds. */
typedef enum hbil_depth_kind {
  HBIL_DEPTH_PLANAR = 0, /* z, along the camera's axis */
  HBIL_DEPTH_RAY = 1,    /* distance from the eye */
  /* The value d of a depth buffer, of any projection; see
   * hbil_frame.hardware_depth, which describes the projection. */
  HBIL_DEPTH_HARDWARE = 2
} hbil_depth_kind;

/* What the input `direct` holds. */
typedef enum hbil_direct_kind {
  HBIL_DIRECT_IRRADIANCE = 0, /* E_direct / direct_scale */
  /* The radiance of direct light that surfaces reflect diffusely, without
   * emission: albedo E_direct / pi / direct_scale, which engines call lit
   * radiance.  The library divides it by the albedo, if there is such an input,
   * and multiplies it by pi.  Where the albedo is below 2^-24, the least half
   * float, surfaces count as unlit: what they reflect tells nothing of the
   * light, and they send none.  An f0 input must not have dimmed it. */
  HBIL_DIRECT_RADIANCE = 1
} hbil_direct_kind;

#ifdef __cplusplus
}
#endif

#endif
