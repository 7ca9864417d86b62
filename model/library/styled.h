/* libstyled: motion restyled in a program's own process, without the daemon, sockets or messages. A
 * C interface; example.c shows a program. On a processor without the instructions of the build
 * (AVX2, unless it was built for an older one) styled_load, styled_read_clip and styled_make_clip
 * fail with a sentence.
 *
 * A network is loaded once and shared by all performers. A performer is one stream of poses of one
 * skeleton: any skeleton, in its own units and axes, as the daemon accepts it. The result is the
 * same skeleton's pose in the style, bit for bit that which a daemon of the same build with default
 * settings publishes.
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

/* The library's version, e.g. "0.2.0". */
STYLED_API const char* styled_version(void);

/* Reads a weights file and tries it on a built-in performer; some 0.2 s. `weights`: a path, or the
 * name of a shipped file ("v2", "open"); NULL: $STYLED_WEIGHTS, else v2 or, where that is not
 * installed, open. Shipped files are searched in the folder `weights` beside the library's own
 * file, in the installation to which that belongs, beside the program, in
 * /usr/share/styled/weights. `precision`: "int8", "float32"; NULL: "int8", as the daemon. Returns
 * NULL on failure, with a sentence in `error` (may be NULL).
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
  /* Joints by hand, where tree and names do not tell: "leftUpperArm=LArm", ..., then NULL; the
   * names on the left are those of the VRM humanoid. NULL: none. */
  const char* const* joints;
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
  STYLED_ERROR_STATE = -3,    /* the bytes are of another network, skeleton or version */
  STYLED_ERROR_FAILED = -4    /* as the function says; a sentence is in its `error` */
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

/* The performer's neutral, how they stand and walk without a style, is learned while they move. It
 * is known sooner and better after a calibration: for `seconds`, 1 to 60, from now on they stand
 * and then walk in their own way. 0: what was learned is forgotten. */
STYLED_API int styled_calibrate(styled_performer* performer, float seconds);

/* A performer's whole state. Another performer of the same network and skeleton continues from it
 * bit for bit. styled_save returns how many bytes the state has, and writes them if `size` is at
 * least that. After STYLED_ERROR_STATE the performer is as new. These two may allocate. */
STYLED_API size_t styled_save(styled_performer* performer, void* bytes, size_t size);
STYLED_API int styled_restore(styled_performer* performer, const void* bytes, size_t size);

/* Whole clips: recorded motion of one skeleton at a constant rate. They are restyled as the program
 * `stylize` does: the performer's neutral is learned from the whole clip first, the style is there
 * from the first frame on, and clips below 30 Hz get frames in between meanwhile. A clip is used
 * by one thread at a time; different clips by any. These functions allocate. */
typedef struct styled_clip styled_clip;

/* Reads a BVH file of any skeleton, and finds its T-pose from its names, zero pose or frames.
 * `joints`: as in styled_body. NULL on failure, with a sentence that names the file and its line.
 */
STYLED_API styled_clip* styled_read_clip(const char* file, const char* const* joints, char* error,
                                         size_t error_size);
/* Makes a clip: `root` [frames][3], `rotations` [frames][joint_count][4], as in styled_frame,
 * finite, of unit length; 1 to 1,000 Hz. Without `rest` the T-pose is found as that of a file. */
STYLED_API styled_clip* styled_make_clip(const styled_body* body, double rate_hz, size_t frames,
                                         const float* root, const float* rotations, char* error,
                                         size_t error_size);
/* Another clip with the same content: for one motion in several styles. NULL: no memory. */
STYLED_API styled_clip* styled_copy_clip(const styled_clip* clip);
STYLED_API void styled_free_clip(styled_clip* clip); /* NULL is allowed */

/* The clip's skeleton, with the T-pose and the joints that were found; it lives as long as the
 * clip. A performer can be created with it. */
STYLED_API const styled_body* styled_clip_body(const styled_clip* clip);
/* How many frames it has; `rate_hz` may be NULL. */
STYLED_API size_t styled_clip_length(const styled_clip* clip, double* rate_hz);
/* Copies all frames to `root` [frames][3] and `rotations` [frames][joint_count][4]. */
STYLED_API int styled_clip_frames(const styled_clip* clip, float* root, float* rotations);

/* Restyles the clip in place; styles and weights as in styled_set. Returns in how many frames no
 * sound styled pose was found, so that they are the performer's own (0 is usual), or, with the clip
 * unchanged, STYLED_ERROR_FAILED. */
STYLED_API int styled_restyle(const styled_network* network, styled_clip* clip,
                              const int32_t* styles, const float* weights, int count, char* error,
                              size_t error_size);
/* Writes a BVH file; one that is there is replaced. STYLED_ERROR_FAILED: it cannot be written. */
STYLED_API int styled_write_clip(const styled_clip* clip, const char* file, char* error,
                                 size_t error_size);

/* Teaches a performer their neutral from a clip in which the same person stands or walks in their
 * own way, on any skeleton. STYLED_ERROR_FAILED: no standing or walking in it, or the network has
 * no use for a neutral. */
STYLED_API int styled_learn(styled_performer* performer, const styled_clip* clip);

/* Makes a style from an example: a network with the same styles, by the same numbers, and as its
 * last one the style `name` as `example` shows it, best 3 s or more of a walk or run. `neutral`, or
 * NULL, is a clip in which the same person does the same in their own way: then only what differs
 * is the style. Where the weights measure a clip rather than encode it, only the clip's own terms
 * apply to the style (styled_style_licence). `network` stays as it is; both are released by their
 * user, and share the weights. Any thread; up to seconds. NULL on failure: the name is taken or
 * empty, the weights know only their list of styles (v2), or the example shows no style. */
STYLED_API styled_network* styled_like(const styled_network* network, const char* name,
                                       const styled_clip* example, const styled_clip* neutral,
                                       char* error, size_t error_size);
/* The performer continues without a jump by a network that styled_like has made, in one step or in
 * several, from theirs: styled_set then takes its styles. STYLED_ERROR_ARGUMENT: by another one. */
STYLED_API int styled_adopt(styled_performer* performer, const styled_network* network);

#ifdef __cplusplus
}
#endif
/* NOLINTEND(readability-identifier-naming) */

#endif
