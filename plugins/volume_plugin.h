/* The interface between isoextract and plug-ins that read volumes. Plain C, so that a plug-in can be built with any
 * compiler and any version of its libraries.
 *
 * A plug-in for the format ID is two files in one folder (or in two of the folders that are searched):
 *
 *    isoextract-volume-ID.txt   its table, read without opening the plug-in, a line each:
 *                                 title: one line for users
 *                                 extensions: .abc .def
 *                                 magic: 128 4449434d     bytes (in hex) that its files have at an offset; any number
 *                                                         of such lines
 *                                 contains: DATASET IMAGE text in the first 1024 bytes of its files; likewise
 *                                 folders: .zgroup .zarray names of entries by which a folder is an input of this
 *                                                         format; * for any folder with a file of this format
 *                                 uses: level slices      what of isoextract_volume_request it uses besides the path
 *                                 library: GDCM 3.0       for users
 *                                 package: libgdcm-dev    what builds it, for users
 *    isoextract-volume-ID.so    a shared object with the function isoextract_volume_plugin()
 *
 * ID is lower case letters, digits, '-' and '_'. The table is there even where the shared object was not
 * built, so that messages can tell what is missing. The shared object is opened only if a file's content, its extension
 * or the user selects the format. Folders are searched in this order: those in the environment variable
 * ISOEXTRACT_PLUGINS, separated by colons; `plugins` beside the program; `../lib/isoextract/plugins` relative to that.
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
#define ISOEXTRACT_VOLUME_PLUGIN_VERSION 4

/* What to list. Members that the plug-in's table does not name are 0. */
typedef struct isoextract_volume_request {
  const char* path;         /* of a file or folder */
  const char* const* files; /* "slices": those of the volume in order, if it is a stack of files; path is the first */
  size_t file_count;        /* 0 if there is one */
  uint64_t volume;          /* the volume that will be read, whose box and placement are to be listed; from 0 */
  uint64_t level;           /* "level": of a pyramid of resolutions; 0 is the finest */
  double spacing[3];        /* "spacing": of the box of samples, for data that do not lie on a lattice; 0: the plug-in
                               chooses, and says so in a note */
  int32_t resamples;        /* "resamples": nonzero to resample unevenly spaced samples; otherwise they are an error */
} isoextract_volume_request;

/* Name and color of one label of a label map. */
typedef struct isoextract_volume_label {
  int64_t value;
  const char* name;
  double color[3];   /* sRGB, each from 0 to 1 */
  int32_t has_color; /* nonzero if the file recommends the color */
} isoextract_volume_label;

/* One grid of a file: a full box of samples, or sparse ones. */
typedef struct isoextract_volume_grid {
  const char* name;            /* "" if the format has a single unnamed volume */
  const char* type_name;       /* type of its values for users: "float", "vec3" */
  const char* world_space;     /* name of its world space, such as "left-posterior-superior"; "" if the file has none */
  const char* length_unit;     /* of its world space, such as "mm"; "" if the file has none */
  int32_t sample_type;         /* isoextract_sample_type */
  int32_t kind;                /* isoextract_volume_kind */
  int32_t is_sparse;           /* nonzero if its samples are blocks and tiles */
  int32_t is_sampled;          /* nonzero if its samples are values of other data at the spacing of the request */
  int32_t has_placement;       /* nonzero if the file states index_to_world, at least a spacing */
  uint64_t dims[3];            /* of a full box: samples along x (fastest), y, z */
  double index_to_world[12];   /* three rows of four: world x, y and z from (i, j, k, 1) of a sample's center */
  double slope, intercept;     /* value of a sample = slope * stored + intercept; 1 and 0 if the file has none */
  uint64_t components;         /* numbers per sample; 1 or more */
  const char* component_names; /* in order, separated by spaces: "x y z"; "" if the file has none */
  uint64_t volumes;            /* volumes with this box, such as time steps; 1 or more */
  const double* volume_times;  /* of each volume; null if the file has none */
  const char* time_unit;       /* "s", "days since 1950-01-01"; "" if the file has none */
  const isoextract_volume_label* labels; /* of a label map, any order; null if the file has none */
  size_t label_count;
  int32_t has_counts; /* sparse grids: nonzero if the file has the counts below */
  uint64_t active_voxels;
  int32_t active_min[3]; /* the box of the active voxels, both corners included */
  int32_t active_max[3];
} isoextract_volume_grid;

/* An opened file. */
typedef struct isoextract_volume_list {
  const char* format;  /* name of the file's format in reports: "VTK image data"; null for that of the plug-in */
  const char* creator; /* the program or device that made the file; null or "" */
  const char* note;    /* for the user: assumptions and omissions, a sentence without a full stop; null or "" */
  const isoextract_volume_grid* grids;
  size_t count;
  const char* const* files; /* files besides the request's path that its samples depend on */
  size_t file_count;
  void* owner; /* for the plug-in's own use, such as the open file */
} isoextract_volume_list;

/* What list() and open() return if they fail. */
enum isoextract_read_failure {
  ISOEXTRACT_READ_FAILED = 1,
  ISOEXTRACT_UNEVEN_SAMPLES = 2 /* samples are spaced unevenly, and resamples is not set */
};

#define ISOEXTRACT_COMPONENT_LENGTH (-1)

/* Which samples of a list to read. */
typedef struct isoextract_volume_selection {
  size_t grid;       /* its index in the list */
  uint64_t volume;   /* from 0 */
  int64_t component; /* from 0; or ISOEXTRACT_COMPONENT_LENGTH: the Euclidean lengths of the values (slope and intercept
                        applied), as f64 if the samples are f64, i32 or u32, else as f32 */
  uint64_t first[3]; /* full boxes: the first of the samples to read, along x, y and z, */
  uint64_t count[3]; /* and their number */
  void* box;         /* full boxes: memory of the host for count[0] * count[1] * count[2] samples, which the plug-in
                        fills, x fastest, in native byte order; aligned to 64 bytes */
} isoextract_volume_selection;

/* What a plug-in returns besides the samples of a full box. */
typedef struct isoextract_volume_samples {
  uint64_t filled;                         /* full boxes: bytes that were written to the selection's box: all of it */
  const isoextract_sparse_samples* sparse; /* the samples of a sparse grid */
  uint64_t parts_read, parts; /* chunks, slices or files that were read, of how many; 0 if there are none */
  const char* note;           /* for the user: assumptions and changes, a sentence without a full stop; null or "" */
  void* owner;                /* for the plug-in's own use */
} isoextract_volume_samples;

typedef struct isoextract_volume_plugin_v4 {
  uint32_t version;   /* ISOEXTRACT_VOLUME_PLUGIN_VERSION; the first member in every version */
  const char* id;     /* the ID in the file name */
  const char* format; /* name of the format in reports: "DICOM" */

  /* Returns nonzero if a file of that path with this start (1024 bytes, or the whole file) may have the format. Not
   * called for folders. */
  int (*probe)(const unsigned char* start, size_t bytes, const char* path);

  /* Opens a file or folder and lists its grids, without reading samples where the format allows that. Returns 0 on
   * success, else an isoextract_read_failure; after a success free_list is called once. Memory that it reserves counts
   * until then. */
  int (*list)(const isoextract_volume_request* request, const isoextract_plugin_host* host,
              isoextract_volume_list* list);
  void (*free_list)(isoextract_volume_list* list);

  /* Reads samples of a list. Returns as list() does; after a success free_samples is called once. The plug-in reserves
   * memory for sparse samples and for everything else that reading needs, but not for the box. */
  int (*open)(const isoextract_volume_list* list, const isoextract_volume_selection* selection,
              const isoextract_plugin_host* host, isoextract_volume_samples* samples);
  void (*free_samples)(isoextract_volume_samples* samples);

  /* Returns why this thread's last call failed: what was expected and what was found, without the file's name. */
  const char* (*error_text)(void);
} isoextract_volume_plugin_v4;

/* The one function that a plug-in exports. Its result must live as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_volume_plugin_v4*
isoextract_volume_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
