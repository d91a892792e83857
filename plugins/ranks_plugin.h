/* The interface between isoextract and a plug-in that connects the processes of one run: the ranks that a launcher such
 * as mpirun started, on one or more machines. Plain C, as the interface for volumes (volume_plugin.h).
 *
 * A plug-in ID is the file isoextract-ranks-ID.so with the function isoextract_ranks_plugin(), in one of the folders
 * that volume_plugin.h lists. It is opened only if the environment says that a launcher started several processes.
 *
 * Calls may come from any thread, several at once. Functions must not throw or print. While they wait, they sleep, so
 * that a rank that waits takes no processor time. Texts are UTF-8, end in 0 and have no line breaks. */
#ifndef ISOEXTRACT_RANKS_PLUGIN_H
#define ISOEXTRACT_RANKS_PLUGIN_H

/* A C header: clang-tidy's checks for C++ do not apply.
 * NOLINTBEGIN */
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Increases with every change of this file. Plug-ins of other versions are rejected. */
#define ISOEXTRACT_RANKS_PLUGIN_VERSION 1

typedef struct isoextract_rank {
  int32_t rank; /* of this process, 0 to size - 1 */
  int32_t size; /* number of ranks */
  int32_t node; /* least rank on this machine */
} isoextract_rank;

typedef struct isoextract_ranks_plugin_v1 {
  uint32_t version; /* ISOEXTRACT_RANKS_PLUGIN_VERSION; the first member in every version */
  const char* id;   /* the ID in the file name */

  /* Connects the ranks. Every rank calls it once, before the other functions. Returns 0 on success. */
  int (*join)(isoextract_rank* own);

  /* Sends bytes to all ranks. Every rank calls it, each with its own bytes. Writes their numbers by rank to `sizes`,
   * which has room for all ranks, and returns the bytes of all ranks one after another. They stay valid until the next
   * call. Returns null on failure. Not called by several threads at once. */
  const void* (*gather)(const void* bytes, uint64_t count, uint64_t* sizes);

  /* Sends a message to one other rank. Returns 0 on success. */
  int (*send)(int32_t to, const void* bytes, uint64_t count);
  /* Waits up to `milliseconds` for a message of any rank. If one came, writes its sender and size, and returns its
   * bytes, which stay valid until the next call. Otherwise returns null, and writes -1 as the sender if no message
   * came, or -2 on failure. Not called by several threads at once. */
  const void* (*receive)(int32_t milliseconds, int32_t* from, uint64_t* count);

  /* Waits until every rank calls it, and ends the connection. */
  void (*leave)(void);

  /* Returns why this thread's last call failed. */
  const char* (*error_text)(void);
} isoextract_ranks_plugin_v1;

/* The one function that a plug-in exports. Its result must live as long as the process. */
#if defined(__GNUC__)
__attribute__((visibility("default")))
#endif
const isoextract_ranks_plugin_v1*
isoextract_ranks_plugin(void);

#ifdef __cplusplus
}
#endif
/* NOLINTEND */

#endif
