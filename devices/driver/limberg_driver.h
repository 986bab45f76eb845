/* A driver of a device, as a shared library that Limberg loads: limberg run SCENE --device driver:PATH[,OPTIONS]
 *
 * A driver is six functions with C linkage, of these names. It links nothing of Limberg and includes this header only.
 *
 *   uint32_t limberg_driver_abi(void);                       returns LIMBERG_DRIVER_ABI
 *   open -> describe -> read_pose, write_force, read_pose, write_force, ... -> close
 *
 * Calls of one device come one after another, those of the loop from one thread that nothing else waits for: read_pose
 * may wait, as long as it is told. Limberg answers each pose by one write_force, at once, and writes a force of zero
 * before close. Places are millimetres and forces newtons in the axes of the scene: x to the right, y away from the one
 * who sits before the device, z up. A device that is turned round says so in options of its own.
 *
 * Limberg bounds what it asks for by what describe says: the peak force, and the stiffness, which is no more than what
 * the device's damping and delay let it hold. A force changes by 0.2 N a millisecond at most. A driver still has to let go by itself when no force comes for 100 ms: Limberg may be killed.
 *
 * Versions: LIMBERG_DRIVER_ABI grows when a struct or a function changes its meaning; a driver of another number is
 * refused, and told so. Structs begin with their size, which Limberg sets: a later one may be longer, and a driver
 * writes no further than it is told.
 */
#ifndef LIMBERG_DRIVER_H
#define LIMBERG_DRIVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define LIMBERG_DRIVER_ABI 1u

/* What a device is and can do. Zeros stay what Limberg takes for a small desk device. */
struct limberg_driver_description {
  uint32_t size;             /* of this struct; set by Limberg */
  uint32_t gives_force;      /* 0: a pointing device; write_force is not called, and may be missing */
  char name[64];             /* for people, ends with a zero */
  double peak_force_N;       /* 0: 3.3 */
  double stiffness_N_mm;     /* that it holds stably in a hand; 0: 2 */
  double damping_N_s_mm;     /* of the coupling; 0: 0.0015 */
  double own_damping_N_s_mm; /* of the device itself, with no force asked for; 0: 0.0005 */
  double delay_ms;           /* from write_force to the read_pose that has seen what it did, beyond 1 ms; 0: none */
  double workspace_mm[3][2]; /* least and greatest, by axis; zeros: not said */
};

/* One reading. */
struct limberg_driver_pose {
  uint32_t size;    /* of this struct; set by Limberg */
  uint32_t buttons; /* bit 0: the tool is engaged; bit 1: clutch */
  double tip_mm[3]; /* where the tool's tip is */
  double quat[4];   /* w, x, y, z of length 1; the shaft is its local +z, from the tip to the hand */
};

enum limberg_driver_result {
  LIMBERG_DRIVER_OK = 0,      /* read_pose: there is a new pose */
  LIMBERG_DRIVER_NOTHING = 1, /* read_pose: none came in time */
  LIMBERG_DRIVER_GONE = 2     /* the device is unplugged: it is closed, and opened again each second */
};

/* The version that the driver was built for. */
uint32_t limberg_driver_abi(void);

/* Opens a device. `options`: what stands behind PATH in --device, "" where nothing does. Null: it cannot be had, and
 * `why` (of `why_size` bytes) says in a few words what is wrong and what was expected. */
void* limberg_driver_open(const char* options, char* why, size_t why_size);

/* What the device that was opened is and can do. */
void limberg_driver_describe(void* device, struct limberg_driver_description* description);

/* The newest pose, waiting for it at most `wait_ms`. One of enum limberg_driver_result. */
int limberg_driver_read_pose(void* device, int wait_ms, struct limberg_driver_pose* pose);

/* The force on the hand until the next call, N. One of enum limberg_driver_result. */
int limberg_driver_write_force(void* device, const double force_N[3]);

/* Ends the force and lets the device go. */
void limberg_driver_close(void* device);

#ifdef __cplusplus
}
#endif

#endif
