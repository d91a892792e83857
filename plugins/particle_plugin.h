/* The interface between isoextract and plug-ins that read particles: plain C, as that of volumes (volume_plugin.h).
 *
 * A plug-in of the format ID is two files in one folder (or in two of the folders that are searched):
 *
 *   isoextract-particles-ID.txt   what is known of it without opening it, a line each:
 *                                   title: one line for people
 *                                   extensions: .abc .def
 *   isoextract-particles-ID.so    a shared object with the function isoextract_particle_plugin()
 *
 * ID is lower case letters, digits, '-' and '_'. The shared object is opened only when a file of its format comes. The
 * folders are those that volume_plugin.h names.
 *
 * All calls may come from any thread, several at once, those for one opened file one after the other. No exception may
 * leave a function, and nothing may be printed. Texts are UTF-8, end in 0 and have no line breaks. */
#ifndef ISOEXTRACT_PARTICLE_PLUGIN_H
#define ISOEXTRACT_PARTICLE_PLUGIN_H

/* A C header: what clang-tidy says of C++ is not for it.
 * NOLINTBEGIN */
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Goes up with every change of this file. A plug-in of another version is refused. */
#define ISOEXTRACT_PARTICLE_PLUGIN_VERSION 3

/* What three numbers are, which decides whether they turn with the mesh. */
typedef enum isoextract_attribute_kind {
  ISOEXTRACT_KIND_NOT_SAID = 0, /* the name of the quantity decides */
  ISOEXTRACT_KIND_SCALAR = 1,
  ISOEXTRACT_KIND_COLOR = 2,
  ISOEXTRACT_KIND_VECTOR = 3,
  ISOEXTRACT_KIND_POINT = 4,
  ISOEXTRACT_KIND_NORMAL = 5
} isoextract_attribute_kind;

/* What is told of each particle under one name, besides its position. */
typedef struct isoextract_particle_quantity {
  const char* name;
  const char* type_name; /* what people call its values: "float" */
  uint64_t components;   /* 1 or more */
  int32_t is_numeric;    /* not 0 if its values can be had as numbers */
  int32_t kind;          /* isoextract_attribute_kind, where the file says it */
} isoextract_particle_quantity;

/* One frame of a file, opened. Valid until it is closed. */
typedef struct isoextract_particle_file {
  uint64_t particles;
  uint64_t frames;         /* in the file */
  const char* frame_name;  /* what the file calls this one; may be empty */
  const char* length_unit; /* of the positions; may be empty */
  const isoextract_particle_quantity* quantities;
  size_t quantity_count;
  uint64_t held_bytes; /* memory that the plug-in has taken for it */
  void* owner;         /* the plug-in's own */
} isoextract_particle_file;

typedef struct isoextract_particle_plugin_v3 {
  uint32_t version; /* ISOEXTRACT_PARTICLE_PLUGIN_VERSION; the first member in every version */
  const char* id;   /* the ID of the file's name */

  /* A frame of the file, counted from 0. 0 if all is well; then close is called once. A frame beyond the last one is no
   * failure where `frames` is told: `particles` is 0 then. `grid` is null or, of a format whose files hold sets of
   * particles by name, the name of one. */
  int (*open)(const char* path, const char* grid, uint64_t frame, isoextract_particle_file* file);
  void (*close)(isoextract_particle_file* file);

  /* Fills 3 * particles numbers: x, y and z of each. 0 if all is well. */
  int (*positions)(const isoextract_particle_file* file, double* values);
  /* Likewise components * particles numbers of a quantity, by its place in the list, those of one particle together. */
  int (*quantity)(const isoextract_particle_file* file, size_t quantity, float* values);

  /* Why the last call of this thread failed: what was expected and what was found, without the file's name. */
  const char* (*error_text)(void);
} isoextract_particle_plugin_v3;

/* The one function that a plug-in exports. What it returns lives as long as the process. */
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
