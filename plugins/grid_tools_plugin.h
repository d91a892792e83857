/* The interface between isoextract and plug-ins that work on sparse grids with a library of the field: plain C, as that
 * of volumes (volume_plugin.h).
 *
 * A plug-in of the name ID is the file isoextract-grids-ID.so with the function isoextract_grid_tools_plugin(), in one
 * of the folders that volume_plugin.h names. It is opened only when one of its tools is asked for.
 *
 * All calls may come from any thread, several at once. No exception may leave a function, and nothing may be printed.
 * Texts are UTF-8, end in 0 and have no line breaks. What goes in stays the host's, and valid during the call. Memory
 * is reserved by the host's callbacks before it is taken. */
#ifndef ISOEXTRACT_GRID_TOOLS_PLUGIN_H
#define ISOEXTRACT_GRID_TOOLS_PLUGIN_H

/* A C header: what clang-tidy says of C++ is not for it.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#include "plugin_samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Goes up with every change of this file. A plug-in of another version is refused. */
#define ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION 3

/* A grid that goes in: sparse samples, or a full box of them. */
typedef struct isoextract_grid_input {
  const isoextract_sparse_samples* sparse; /* or null, and then: */
  const void* data;                        /* dims[0] * dims[1] * dims[2] samples, x fastest, in native byte order */
  uint64_t dims[3];                        /* samples along x, y, z; each less than 2^29 */
  int32_t sample_type;                     /* isoextract_sample_type, of `data` */
  double slope, intercept;                 /* a sample stands for slope * stored + intercept */
  int32_t kind;                            /* isoextract_volume_kind */
  double index_to_world[12];               /* three rows of four, as in isoextract_volume_grid */
} isoextract_grid_input;

/* A grid that comes out, of f32 samples. */
typedef struct isoextract_grid_output {
  isoextract_sparse_samples samples;
  double index_to_world[12];
  int32_t kind;      /* isoextract_volume_kind */
  uint64_t left_out; /* particles smaller than `least_radius` */
  void* owner;       /* the plug-in's own */
} isoextract_grid_output;

enum isoextract_sphere_method {
  /* The union of the spheres. */
  ISOEXTRACT_SPHERES = 0,
  /* The surface of averaged positions: Y. Zhu and R. Bridson, "Animating sand as a fluid", SIGGRAPH 2005, section 5. */
  ISOEXTRACT_SMOOTH_SPHERES = 1
};

typedef struct isoextract_sphere_job {
  const double* positions; /* 3 * count: x, y and z of each, in the world; finite */
  uint64_t count;
  const float* radii; /* of each, in the world; or null, and then `radius` holds for all */
  double radius;
  double search_radius; /* of the smooth method: how far a particle reaches; at least the largest radius */
  double voxel;         /* spacing of the grid that comes out; its sample (0, 0, 0) is at the world's origin */
  double half_band;     /* of the level set, in voxels, on either side of the surface; 2 or more */
  double least_radius;  /* in voxels: smaller particles are left out, and counted */
  int32_t method;       /* isoextract_sphere_method */
  int32_t kind;         /* level set: distance in the world, negative inside; density: 1 inside, 0 outside and a ramp of
                           half_band voxels inside of the surface */
} isoextract_sphere_job;

enum isoextract_level_set_filter { ISOEXTRACT_GAUSSIAN = 0, ISOEXTRACT_MEDIAN = 1, ISOEXTRACT_MEAN = 2 };

typedef struct isoextract_filter_job {
  isoextract_grid_input grid; /* a level set of cubic voxels */
  int32_t filter;             /* isoextract_level_set_filter */
  uint32_t width;             /* voxels on either side that a value is taken from; 1 or more */
  uint32_t iterations;
} isoextract_filter_job;

typedef struct isoextract_named_grid {
  isoextract_grid_input grid;
  const char* name;
} isoextract_named_grid;

typedef struct isoextract_vdb_job {
  const isoextract_named_grid* grids; /* of the file, in their order */
  uint64_t count;                     /* 1 or more */
  int32_t is_half;                    /* not 0 if values are to be stored as 16-bit numbers */
  /* Where the bytes of the file go: appended, or, where overwrite is not null, put in the place of some that were
   * written. 0 if all is well. Without overwrite the file has no places of its grids, as one that is piped. */
  void* sink;
  int (*append)(void* sink, const void* bytes, uint64_t count);
  int (*overwrite)(void* sink, uint64_t place, const void* bytes, uint64_t count);
} isoextract_vdb_job;

typedef struct isoextract_grid_tools_plugin_v3 {
  uint32_t version; /* ISOEXTRACT_GRID_TOOLS_PLUGIN_VERSION; the first member in every version */
  const char* id;   /* the ID of the file's name */

  /* 0 if all is well; of those with an output, free_output is called once then. */
  int (*spheres)(const isoextract_sphere_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output);
  int (*filter)(const isoextract_filter_job* job, const isoextract_plugin_host* host, isoextract_grid_output* output);
  void (*free_output)(isoextract_grid_output* output);

  /* Grids of floats as an OpenVDB file; samples of other types are rounded to them. Voxels are active whose value is
   * neither the background nor, in a level set, the background with the other sign. Beyond a full box there is its
   * least value, of a level set its greatest. */
  int (*write_vdb)(const isoextract_vdb_job* job, const isoextract_plugin_host* host);

  /* Why the last call of this thread failed: what was expected and what was found. */
  const char* (*error_text)(void);
} isoextract_grid_tools_plugin_v3;

/* The one function that a plug-in exports. What it returns lives as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_grid_tools_plugin_v3*
isoextract_grid_tools_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
