/* The interface between isoextract and plug-ins that read particles. Plain C, as the interface for volumes
 * (volume_plugin.h).
 *
 * A plug-in for the format ID is two files in one folder (or in two of the folders that are searched):
 *
 *    isoextract-particles-ID.txt   its table, read without opening the plug-in, a line each:
 *                                    title: one line for users
 *                                    extensions: .abc .def
 *    isoextract-particles-ID.so    a shared object with the function isoextract_particle_plugin()
 *
 * ID is lower case letters, digits, '-' and '_'. The shared object is opened only for a file of its format. The
 * folders are those that volume_plugin.h lists.
 *
 * Calls may come from any thread, several at once, but only one at a time for an opened file. Functions must not
 * throw or print. Texts are UTF-8, end in 0 and have no line breaks. */
#ifndef ISOEXTRACT_PARTICLE_PLUGIN_H
#define ISOEXTRACT_PARTICLE_PLUGIN_H

/* A C header: clang-tidy's checks for C++ do not apply.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increases with every change of this file. Plug-ins of other versions are rejected. */
#define ISOEXTRACT_PARTICLE_PLUGIN_VERSION 3

/* Meaning of three numbers, which decides whether they are transformed with the mesh. */
typedef enum isoextract_attribute_kind {
  ISOEXTRACT_KIND_NOT_SAID = 0, /* decided by the name of the quantity */
  ISOEXTRACT_KIND_SCALAR = 1,
  ISOEXTRACT_KIND_COLOR = 2,
  ISOEXTRACT_KIND_VECTOR = 3,
  ISOEXTRACT_KIND_POINT = 4,
  ISOEXTRACT_KIND_NORMAL = 5
} isoextract_attribute_kind;

/* Named data of each particle, besides its position. */
typedef struct isoextract_particle_quantity {
  const char* name;
  const char* type_name; /* type of its values for users: "float" */
  uint64_t components;   /* 1 or more */
  int32_t is_numeric;    /* nonzero if its values can be read as numbers */
  int32_t kind;          /* isoextract_attribute_kind, if the file specifies it */
} isoextract_particle_quantity;

/* An opened frame of a file. Valid until it is closed. */
typedef struct isoextract_particle_file {
  uint64_t particles;
  uint64_t frames;         /* in the file */
  const char* frame_name;  /* the file's name of this frame; may be empty */
  const char* length_unit; /* of the positions; may be empty */
  const isoextract_particle_quantity* quantities;
  size_t quantity_count;
  uint64_t held_bytes; /* memory that the plug-in has allocated for it */
  void* owner;         /* for the plug-in's own use */
} isoextract_particle_file;

typedef struct isoextract_particle_plugin_v3 {
  uint32_t version; /* ISOEXTRACT_PARTICLE_PLUGIN_VERSION; the first member in every version */
  const char* id;   /* the ID in the file name */

  /* Opens a frame of the file, counted from 0. Returns 0 on success; then close is called once. A frame after the
   * last one is a success if `frames` is set; `particles` is 0 then. `grid` is null or the name of a particle set,
   * for formats with named sets. */
  int (*open)(const char* path, const char* grid, uint64_t frame, isoextract_particle_file* file);
  void (*close)(isoextract_particle_file* file);

  /* Fills 3 * particles numbers: x, y and z of each. Returns 0 on success. */
  int (*positions)(const isoextract_particle_file* file, double* values);
  /* Fills components * particles numbers of a quantity, given by its index; those of one particle are consecutive.
   * Returns 0 on success. */
  int (*quantity)(const isoextract_particle_file* file, size_t quantity, float* values);

  /* Returns why this thread's last call failed: what was expected and what was found, without the file's name. */
  const char* (*error_text)(void);
} isoextract_particle_plugin_v3;

/* The one function that a plug-in exports. Its result must live as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_particle_plugin_v3*
isoextract_particle_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
