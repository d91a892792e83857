/* The interface between isoextract and plug-ins that read volumes. Plain C, so that a plug-in can be built with any
 * compiler and any version of its libraries.
 *
 * A plug-in for the format ID is two files in one folder (or in two of the folders that are searched):
 *
 *    isoextract-volume-ID.txt   its table, read without opening the plug-in, a line each:
 *                                 title: one line for users
 *                                 extensions: .abc .def
 *    isoextract-volume-ID.so    a shared object with the function isoextract_volume_plugin()
 *
 * ID is lower case letters, digits, '-' and '_'. The shared object is opened only if a file's extension or the user
 * selects the format. Folders are searched in this order: those in the environment variable ISOEXTRACT_PLUGINS,
 * separated by colons; `plugins` beside the program; `../lib/isoextract/plugins` relative to that.
 *
 * Calls may come from any thread, several at once. Functions must not throw. Texts are UTF-8, end in 0 and have no
 * line breaks. Results of a function stay valid until they are freed. */
#ifndef ISOEXTRACT_VOLUME_PLUGIN_H
#define ISOEXTRACT_VOLUME_PLUGIN_H

/* A C header: clang-tidy's checks for C++ do not apply.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#include "plugin_samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Increases with every change of this file. Plug-ins of other versions are rejected. */
#define ISOEXTRACT_VOLUME_PLUGIN_VERSION 3

/* One grid of a file: a full box of samples, or sparse ones. */
typedef struct isoextract_volume_grid {
  const char* name;          /* "" if the format has a single unnamed volume */
  const char* type_name;     /* type of its values for users: "float", "vec3" */
  const char* world_space;   /* name of its world space; "" if the file has none */
  int32_t sample_type;       /* isoextract_sample_type */
  int32_t kind;              /* isoextract_volume_kind */
  int32_t is_sparse;         /* nonzero if its samples are blocks and tiles */
  uint64_t dims[3];          /* of a full box: samples along x (fastest), y, z */
  double index_to_world[12]; /* three rows of four: world x, y and z from (i, j, k, 1) of a sample's center */
  int32_t has_counts;        /* sparse grids: nonzero if the file has the counts below */
  uint64_t active_voxels;
  int32_t active_min[3]; /* the box of the active voxels, both corners included */
  int32_t active_max[3];
} isoextract_volume_grid;

typedef struct isoextract_volume_list {
  const isoextract_volume_grid* grids;
  size_t count;
  void* owner; /* for the plug-in's own use */
} isoextract_volume_list;

/* The samples of a grid: `data`, or `sparse` if the grid is_sparse. */
typedef struct isoextract_volume_samples {
  const void* data; /* dims[0] * dims[1] * dims[2] samples, x fastest, in native byte order, aligned for their type */
  uint64_t bytes;   /* size of all samples */
  const isoextract_sparse_samples* sparse;
  const char* note; /* for the user: assumptions and changes, a sentence without a full stop; null or "" */
  void* owner;      /* for the plug-in's own use */
} isoextract_volume_samples;

typedef struct isoextract_volume_plugin_v3 {
  uint32_t version;   /* ISOEXTRACT_VOLUME_PLUGIN_VERSION; the first member in every version */
  const char* id;     /* the ID in the file name */
  const char* format; /* name of the format in reports: "DICOM" */

  /* Returns nonzero if a file of that path with this start (1024 bytes, or the whole file) may have the format. */
  int (*probe)(const unsigned char* start, size_t bytes, const char* path);

  /* Lists the grids of a file without reading samples. Returns 0 on success; then free_list is called once. */
  int (*list)(const char* path, isoextract_volume_list* list);
  void (*free_list)(isoextract_volume_list* list);

  /* Reads the samples of a grid, given by its index in the list. Returns 0 on success; then free_samples is called
   * once. The host reserves the memory for a full box before the call. The plug-in reserves memory for sparse
   * samples and for everything else that reading needs. */
  int (*open)(const char* path, size_t grid, const isoextract_plugin_host* host, isoextract_volume_samples* samples);
  void (*free_samples)(isoextract_volume_samples* samples);

  /* Returns why this thread's last call failed: what was expected and what was found, without the file's name. */
  const char* (*error_text)(void);
} isoextract_volume_plugin_v3;

/* The one function that a plug-in exports. Its result must live as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_volume_plugin_v3*
isoextract_volume_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
