// SPDX-License-Identifier: Apache-2.0
// fake_preload.h - between the calls that the preload library catches (fake_preload_calls.c) and its camera.
//
// All functions return as the call of the kernel, with errno.
#ifndef SHEEN_TESTS_FAKE_FAKE_PRELOAD_H
#define SHEEN_TESTS_FAKE_FAKE_PRELOAD_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

bool fake_camera_has_path(const char *path);
bool fake_camera_has_fd(int fd);
int fake_camera_node(void);
int fake_camera_open(const char *path, int flags);
int fake_camera_close(int fd); // of the camera's side; the descriptor itself is the caller's to close
int fake_camera_ioctl(int fd, unsigned long request, void *arg);
// The file and the place in it that a mapping of the node really means. False: errno.
bool fake_camera_map(int *file, int fd, size_t length_bytes, off_t offset_bytes);
int fake_camera_poll(int fd); // POLL*

#endif
