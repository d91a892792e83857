/* The interface between isoextract and plug-ins that read volumes: plain C, so that a plug-in may be built with any
 * compiler, against any version of the libraries that it needs.
 *
 * A plug-in of the format ID is two files in one folder (or in two of the folders that are searched):
 *
 *   isoextract-volume-ID.txt   what is known of it without opening it, a line each:
 *                                title: one line for people
 *                                extensions: .abc .def
 *   isoextract-volume-ID.so    a shared object with the function isoextract_volume_plugin()
 *
 * ID is lower case letters, digits, '-' and '_'. The shared object is opened only when a file's extension or the user
 * asks for the format. The folders are those of the environment variable ISOEXTRACT_PLUGINS (colons between them), then
 * `plugins` beside the program, then `../lib/isoextract/plugins` from there.
 *
 * All calls may come from any thread, several at once. No exception may leave a function. Texts are UTF-8, end in 0 and
 * have no line breaks. What a function gives out stays valid until it is given back. */
#ifndef ISOEXTRACT_VOLUME_PLUGIN_H
#define ISOEXTRACT_VOLUME_PLUGIN_H

/* A C header: what clang-tidy says of C++ is not for it.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#include "plugin_samples.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Goes up with every change of this file. A plug-in of another version is refused. */
#define ISOEXTRACT_VOLUME_PLUGIN_VERSION 3

/* One grid of a file: a full box of samples, or sparse ones. */
typedef struct isoextract_volume_grid {
  const char* name;          /* "" where the format has one volume without a name */
  const char* type_name;     /* what people call its values: "float", "vec3" */
  const char* world_space;   /* what the file calls its world; "" where it does not */
  int32_t sample_type;       /* isoextract_sample_type */
  int32_t kind;              /* isoextract_volume_kind */
  int32_t is_sparse;         /* not 0 if its samples come as blocks and tiles */
  uint64_t dims[3];          /* of a full box: samples along x (fastest), y, z */
  double index_to_world[12]; /* three rows of four: x, y and z of the world from (i, j, k, 1) of a sample's centre */
  int32_t has_counts;        /* of sparse samples: not 0 if the file tells the following */
  uint64_t active_voxels;
  int32_t active_min[3]; /* the box of them, both corners included */
  int32_t active_max[3];
} isoextract_volume_grid;

typedef struct isoextract_volume_list {
  const isoextract_volume_grid* grids;
  size_t count;
  void* owner; /* the plug-in's own */
} isoextract_volume_list;

/* The samples of a grid: `data`, or `sparse` where the grid is_sparse. */
typedef struct isoextract_volume_samples {
  const void* data; /* dims[0] * dims[1] * dims[2] samples, x fastest, in native byte order, aligned for their type */
  uint64_t bytes;   /* of all of them */
  const isoextract_sparse_samples* sparse;
  const char* note; /* a sentence for the user without a full stop, about what was assumed or changed; null or "" */
  void* owner;      /* the plug-in's own */
} isoextract_volume_samples;

typedef struct isoextract_volume_plugin_v3 {
  uint32_t version;   /* ISOEXTRACT_VOLUME_PLUGIN_VERSION; the first member in every version */
  const char* id;     /* the ID of the file's name */
  const char* format; /* what reports call the format: "DICOM" */

  /* Not 0 if a file of that path, which starts with these bytes (1024, or all that it has), can be of the format. */
  int (*probe)(const unsigned char* start, size_t bytes, const char* path);

  /* What is in the file, without reading samples. 0 if all is well; then free_list is called once. */
  int (*list)(const char* path, isoextract_volume_list* list);
  void (*free_list)(isoextract_volume_list* list);

  /* The samples of a grid, by its place in the list. 0 if all is well; then free_samples is called once. Memory for a
   * full box is reserved by the host before it calls; what sparse samples take, and what reading needs besides, the
   * plug-in reserves. */
  int (*open)(const char* path, size_t grid, const isoextract_plugin_host* host, isoextract_volume_samples* samples);
  void (*free_samples)(isoextract_volume_samples* samples);

  /* Why the last call of this thread failed: what was expected and what was found, without the file's name. */
  const char* (*error_text)(void);
} isoextract_volume_plugin_v3;

/* The one function that a plug-in exports. What it returns lives as long as the process. */
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
