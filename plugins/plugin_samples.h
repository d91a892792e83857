/* Shared by all plug-in interfaces: sample types, sparse samples, and the host's callbacks. Plain C. A change here
 * changes every interface that includes it. */
#ifndef ISOEXTRACT_PLUGIN_SAMPLES_H
#define ISOEXTRACT_PLUGIN_SAMPLES_H

/* A C header: clang-tidy's checks for C++ do not apply.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum isoextract_sample_type {
  ISOEXTRACT_NOT_SCALAR = 0, /* listed, but not opened: no surface can be extracted */
  ISOEXTRACT_U8 = 1,
  ISOEXTRACT_I8 = 2,
  ISOEXTRACT_U16 = 3,
  ISOEXTRACT_I16 = 4,
  ISOEXTRACT_U32 = 5,
  ISOEXTRACT_I32 = 6,
  ISOEXTRACT_F16 = 7,
  ISOEXTRACT_F32 = 8,
  ISOEXTRACT_F64 = 9
};

enum isoextract_volume_kind {
  ISOEXTRACT_DENSITY = 0,  /* inside is value > iso */
  ISOEXTRACT_LEVEL_SET = 1 /* inside is value < iso */
};

/* 8 x 8 x 8 samples. Sample origin + (x, y, z) has the index x * 64 + y * 8 + z. */
typedef struct isoextract_sparse_block {
  int32_t origin[3];  /* multiples of 8 */
  const void* values; /* 512 samples in native byte order, aligned for their type */
} isoextract_sparse_block;

/* A cube of samples with one value. */
typedef struct isoextract_sparse_tile {
  int32_t origin[3]; /* multiples of the size */
  int32_t size;      /* samples per side: a power of two, 8 or more */
  double value;
} isoextract_sparse_tile;

/* Blocks, tiles, and a background everywhere else. Blocks and tiles must not overlap. */
typedef struct isoextract_sparse_samples {
  int32_t sample_type;                   /* isoextract_sample_type */
  const isoextract_sparse_block* blocks; /* sorted by origin: x, then y, then z; no two with the same origin */
  size_t block_count;
  const isoextract_sparse_tile* tiles;
  size_t tile_count;
  double background;
  int32_t active_min[3]; /* the box of the active voxels, both corners included; */
  int32_t active_max[3]; /* empty if max < min */
  uint64_t active_voxels;
} isoextract_sparse_samples;

/* Callbacks for the duration of a call, from its own thread or from threads that it waits for. */
typedef struct isoextract_plugin_host {
  void* self;
  /* reserve() must be called before allocating memory and returns 0 if it is granted; otherwise the call must fail.
   * Reserved bytes count until they are released, or until the call's results are freed. */
  int (*reserve)(void* self, uint64_t bytes);
  void (*release)(void* self, uint64_t bytes);
  /* Allocates memory for output samples, reserved by the host: aligned to 64 bytes, uninitialized. Returns null if
   * there is none; then the call must fail. The host owns it and keeps it until the call's results are freed.
   * Samples in other memory are copied if the plug-in runs in a separate process. */
  void* (*allocate)(void* self, uint64_t bytes);
  /* Returns nonzero if the call must soon end with a failure. */
  int (*is_cancelled)(void* self);
} isoextract_plugin_host;

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
