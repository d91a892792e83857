/* The interface between isoextract and plug-ins that process sparse grids with another library. Plain C, as the
 * interface for volumes (volume_plugin.h).
 *
 * A plug-in ID is the file isoextract-grids-ID.so with the function isoextract_grid_tools_plugin(), in one of the
 * folders that volume_plugin.h lists. It is opened only when one of its tools is needed.
 *
 * Calls may come from any thread, several at once. Functions must not throw or print. Texts are UTF-8, end in 0 and
 * have no line breaks. Inputs belong to the host and are valid during the call. The plug-in must reserve memory by
 * the host's callbacks before allocating it. */
#ifndef ISOEXTRACT_GRID_TOOLS_PLUGIN_H
#define ISOEXTRACT_GRID_TOOLS_PLUGIN_H

/* A C header: clang-tidy's checks for C++ do not apply.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#include "plugin_samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Increases with every change of this file. Plug-ins of other versions are rejected. */
#define ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION 4

/* An input grid: sparse samples, or a full box of them. */
typedef struct isoextract_grid_input {
  const isoextract_sparse_samples* sparse; /* or null; then `data` has the samples */
  const void* data;                        /* dims[0] * dims[1] * dims[2] samples, x fastest, in native byte order */
  uint64_t dims[3];                        /* samples along x, y, z; each less than 2^29 */
  int32_t sample_type;                     /* isoextract_sample_type of `data` */
  double slope, intercept;                 /* value of a sample = slope * stored + intercept */
  int32_t kind;                            /* isoextract_volume_kind */
  double index_to_world[12];               /* three rows of four, as in isoextract_volume_grid */
} isoextract_grid_input;

/* An output grid of f32 samples. */
typedef struct isoextract_grid_output {
  isoextract_sparse_samples samples;
  double index_to_world[12];
  int32_t kind;      /* isoextract_volume_kind */
  uint64_t left_out; /* number of particles smaller than `least_radius` */
  void* owner;       /* for the plug-in's own use */
} isoextract_grid_output;

enum isoextract_sphere_method {
  /* Union of the spheres. */
  ISOEXTRACT_SPHERES = 0,
  /* Surface of averaged positions: Y. Zhu and R. Bridson, "Animating sand as a fluid", SIGGRAPH 2005, section 5.
   * Without bodies between the spheres; every body contains a sample of a sphere. */
  ISOEXTRACT_SMOOTH_SPHERES = 1
};

typedef struct isoextract_sphere_job {
  const double* positions; /* 3 * count: x, y and z of each, in world units; finite */
  uint64_t count;
  const float* radii; /* of each, in world units; or null, then `radius` is that of all */
  double radius;
  double search_radius; /* smooth method: reach of a particle in world units; at least twice its radius is used */
  double voxel;         /* spacing of the output grid; its sample (0, 0, 0) is at the world's origin */
  double half_band;     /* of the level set, in voxels on either side of the surface; 2 or more */
  double least_radius;  /* in voxels: smaller particles are omitted and counted */
  int32_t method;       /* isoextract_sphere_method */
  int32_t kind;         /* level set: distance in world units, negative inside; density: 1 inside, 0 outside, with a
                           ramp of half_band voxels inside the surface */
} isoextract_sphere_job;

enum isoextract_level_set_filter { ISOEXTRACT_GAUSSIAN = 0, ISOEXTRACT_MEDIAN = 1, ISOEXTRACT_MEAN = 2 };

typedef struct isoextract_filter_job {
  isoextract_grid_input grid; /* a level set of cubic voxels */
  int32_t filter;             /* isoextract_level_set_filter */
  uint32_t width;             /* filter radius in voxels; 1 or more */
  uint32_t iterations;
} isoextract_filter_job;

/* A level set on another lattice: near the surface the linear interpolant of the input, else distances from it. */
typedef struct isoextract_rebuild_job {
  isoextract_grid_input grid; /* a level set with perpendicular axes */
  double first[3];            /* the output's sample (0, 0, 0), as an index of the input */
  double step[3];             /* between output samples, in voxels of the input; above 0, for cubic output voxels */
  double half_band;           /* of the output, in its voxels on either side of the surface; 2 to 1000 */
} isoextract_rebuild_job;

typedef struct isoextract_named_grid {
  isoextract_grid_input grid;
  const char* name;
} isoextract_named_grid;

typedef struct isoextract_vdb_job {
  const isoextract_named_grid* grids; /* the grids of the file in order */
  uint64_t count;                     /* 1 or more */
  int32_t is_half;                    /* nonzero: values are stored as 16-bit floats */
  /* Receive the bytes of the file: append adds them at the end, overwrite replaces `count` written bytes at `place`.
   * They return 0 on success. If overwrite is null, the file is written as a stream, without grid positions. */
  void* sink;
  int (*append)(void* sink, const void* bytes, uint64_t count);
  int (*overwrite)(void* sink, uint64_t place, const void* bytes, uint64_t count);
} isoextract_vdb_job;

typedef struct isoextract_grid_tools_plugin_v4 {
  uint32_t version; /* ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION; the first member in every version */
  const char* id;   /* the ID in the file name */

  /* Return 0 on success; then free_output is called once for each output. */
  int (*spheres)(const isoextract_sphere_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output);
  int (*filter)(const isoextract_filter_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output);
  /* The transform of this output has no meaning. */
  int (*rebuild)(const isoextract_rebuild_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output);
  void (*free_output)(isoextract_grid_output* output);

  /* Writes an upper bound of the bytes of the grids that spheres() works on. Returns 0 on success. */
  int (*sphere_bytes)(const isoextract_sphere_job* job, const isoextract_plugin_host* host, uint64_t* bytes);

  /* Writes float grids as an OpenVDB file; other sample types are rounded to float. A voxel is active if its value
   * is not the background nor, in a level set, the negative background. The background of a full box is its least
   * value, for a level set its greatest. */
  int (*write_vdb)(const isoextract_vdb_job* job, const isoextract_plugin_host* host);

  /* Returns why this thread's last call failed: what was expected and what was found. */
  const char* (*error_text)(void);
} isoextract_grid_tools_plugin_v4;

/* The one function that a plug-in exports. Its result must live as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_grid_tools_plugin_v4*
isoextract_grid_tools_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
