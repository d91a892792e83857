/* What the interfaces to plug-ins share: types of samples, sparse samples, and what the host does for a plug-in. Plain
 * C. A change here is a change of every interface that includes it. */
#ifndef ISOEXTRACT_PLUGIN_SAMPLES_H
#define ISOEXTRACT_PLUGIN_SAMPLES_H

/* A C header: what clang-tidy says of C++ is not for it.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum isoextract_sample_type {
  ISOEXTRACT_NOT_SCALAR = 0, /* no surface can be extracted from it: it is listed, and not opened */
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

/* 8 x 8 x 8 samples. Sample origin + (x, y, z) is number x * 64 + y * 8 + z. */
typedef struct isoextract_sparse_block {
  int32_t origin[3];  /* multiples of 8 */
  const void* values; /* 512 of the samples' type, in native byte order, aligned for it */
} isoextract_sparse_block;

/* A cube of samples of one value. */
typedef struct isoextract_sparse_tile {
  int32_t origin[3]; /* multiples of the size */
  int32_t size;      /* samples a side: a power of two from 8 on */
  double value;
} isoextract_sparse_tile;

/* Blocks, tiles, and a background everywhere else. No block lies in a tile, and no two overlap. */
typedef struct isoextract_sparse_samples {
  int32_t sample_type;                   /* isoextract_sample_type */
  const isoextract_sparse_block* blocks; /* sorted by origin: x, then y, then z; no two of one origin */
  size_t block_count;
  const isoextract_sparse_tile* tiles;
  size_t tile_count;
  double background;
  int32_t active_min[3]; /* the box of the voxels that are of interest, both corners included; */
  int32_t active_max[3]; /* empty where max < min */
  uint64_t active_voxels;
} isoextract_sparse_samples;

/* What the host does for a plug-in during a call. To be called from the call's own thread or from threads that it waits
 * for. */
typedef struct isoextract_plugin_host {
  void* self;
  /* Asked before that much memory is taken. 0 if it may be; if not, the call is to end with a failure. What is reserved
   * counts until it is given back, or until what the call gave out is freed. */
  int (*reserve)(void* self, uint64_t bytes);
  void (*release)(void* self, uint64_t bytes);
  /* Memory for samples that the call gives out, reserved by the host: aligned to 64 bytes, with any content. Null where
   * there is none; then the call is to end with a failure. It is the host's, and lives until what the call gave out is
   * freed. Samples elsewhere are copied where the plug-in runs in a process of its own. */
  void* (*allocate)(void* self, uint64_t bytes);
  /* Not 0 if the call is to end soon, with a failure. */
  int (*is_cancelled)(void* self);
} isoextract_plugin_host;

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
