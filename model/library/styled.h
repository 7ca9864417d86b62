/* libstyled: motion restyled in a program's own process, without the daemon, sockets or messages. A
 * C interface; example.c shows a program. The processor needs AVX2, as for the daemon.
 *
 * A network is loaded once and shared by all performers. A performer is one stream of poses of one
 * skeleton: any skeleton, in its own units and axes, as the daemon accepts it. The result is the
 * same skeleton's pose in the style: except for the last bits of a rotation it is the pose that a
 * daemon with default settings publishes.
 *
 * Conventions. Right-handed axes; rotations are quaternions x, y, z, w, relative to the joint's
 * parent; joint 0 is the root, and parents precede their children. Time is in nanoseconds from any
 * moment. Strings are UTF-8, and belong to the library where it returns them.
 *
 * Threads. A network may be used by all threads. A performer is used by one thread at a time.
 *
 * Allocation. styled_frame, styled_set and styled_reset allocate nothing, lock nothing and log
 * nothing.
 *
 * Stability. A program that was built with version 0.N runs with every libstyled.so.0. Functions
 * are only added; a struct has a size first, so that fields can follow. */
#ifndef STYLED_LIBRARY_STYLED_H
#define STYLED_LIBRARY_STYLED_H

#include <stddef.h>
#include <stdint.h>

/* NOLINTBEGIN(readability-identifier-naming): the names are those of C */
#ifdef __cplusplus
extern "C" {
#endif

#define STYLED_API __attribute__((visibility("default")))

typedef struct styled_network styled_network;
typedef struct styled_performer styled_performer;

/* The library's version, e.g. "0.1.0". */
STYLED_API const char* styled_version(void);

/* Reads a weights file and tries it on a built-in performer; some 0.2 s. `weights`: a path, or the
 * name of a shipped file ("v2", "open"); NULL: $STYLED_WEIGHTS, else the
 * shipped default. Shipped files are searched beside the program and in /usr/share/styled/weights.
 * `precision`: "int8", "float32"; NULL: "int8", as the daemon. Returns NULL on failure, with a
 * sentence in `error` (may be NULL).
 */
STYLED_API styled_network* styled_load(const char* weights, const char* precision, char* error,
                                       size_t error_size);
/* Performers keep the network that they need: it may be released before them. NULL is allowed. */
STYLED_API void styled_release(styled_network* network);

/* Styles are numbered from 0, which is neutral: the performer's own motion. */
STYLED_API int styled_style_count(const styled_network* network);
/* NULL if there is no such style. */
STYLED_API const char* styled_style_name(const styled_network* network, int style);
/* The licence of a style, e.g. "CC BY-NC 4.0", and the names that it must be credited to; "" if the
 * file does not say. NULL if there is no such style. */
STYLED_API const char* styled_style_licence(const styled_network* network, int style);
STYLED_API const char* styled_style_credit(const styled_network* network, int style);
/* A style's number by its name or alias, in upper or lower case; -1 if there is none. */
STYLED_API int styled_find_style(const styled_network* network, const char* name);

typedef struct styled_body {
  size_t size;              /* sizeof(styled_body) */
  int joint_count;          /* 1 .. 256 */
  const char* const* names; /* [joint_count], all different */
  const int32_t* parents;   /* [joint_count]; -1 for joint 0, an earlier joint for the others */
  const float* offsets;     /* [joint_count][3], from the parent, in the parent's axes */
  const float* rest;        /* [joint_count][4], world rotations in the T-pose; NULL: by dialect */
  const char* dialect;      /* "cmu", "rokoko", ...; NULL: found by the names */
} styled_body;

/* A new performer with this skeleton, who moves in their own style. Joints are found by the
 * skeleton's tree and names. The arrays are copied. Returns NULL on failure, with a sentence in
 * `error` that names the joint. */
STYLED_API styled_performer* styled_create(const styled_network* network, const styled_body* body,
                                           char* error, size_t error_size);
STYLED_API void styled_destroy(styled_performer* performer); /* NULL is allowed */

/* The results of the functions below. */
enum {
  STYLED_OK = 0,
  STYLED_ERROR_ARGUMENT = -1, /* a number out of range, or a NULL */
  STYLED_ERROR_TIME = -2,     /* not after the last frame's; the frame is left out */
  STYLED_ERROR_STATE = -3     /* the bytes are of another network, skeleton or version */
};

/* From the next frame on: a mix of `count` different styles but neutral, 0 .. 4, each with a weight
 * of 0 .. 1.5, which sum to at most 1.5. 0 styles: the performer's own. The change fades in over
 * `transition_s`, 0 .. 60 (0.1 is usual). */
STYLED_API int styled_set(styled_performer* performer, const int32_t* styles, const float* weights,
                          int count, float transition_s);

/* Bits of styled_frame's `flags`; the others are reserved. */
enum {
  STYLED_FLAG_HELD = 16,    /* a joint was not finite or the root jumped: the last value */
  STYLED_FLAG_BYPASS = 32,  /* the performer's own motion, bit for bit */
  STYLED_FLAG_FADING = 128, /* a change of style is under way */
  STYLED_FLAG_FAILED = 256  /* the styled pose was not sound, so the performer's own is given */
};

/* Restyles a frame. `time_ns` is after the last frame's and within 2^61 of 0; frames may come at
 * any rate from 4 to 1,000 Hz. `root` [3] is joint 0's position, `rotations` [joint_count][4] the
 * joints'. Writes `styled_root` [3] and `styled_rotations` [joint_count][4], which may be the same
 * arrays, and, unless it is NULL, `flags`. */
STYLED_API int styled_frame(styled_performer* performer, int64_t time_ns, const float* root,
                            const float* rotations, float* styled_root, float* styled_rotations,
                            uint32_t* flags);

/* Before another take: as a new performer, except for the style and what was learnt of the
 * performer's neutral motion. The next frame's time may be anything. */
STYLED_API int styled_reset(styled_performer* performer);

/* A performer's whole state. Another performer of the same network and skeleton continues from it
 * bit for bit. styled_save returns how many bytes the state has, and writes them if `size` is at
 * least that. After STYLED_ERROR_STATE the performer is as new. These two may allocate. */
STYLED_API size_t styled_save(styled_performer* performer, void* bytes, size_t size);
STYLED_API int styled_restore(styled_performer* performer, const void* bytes, size_t size);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
