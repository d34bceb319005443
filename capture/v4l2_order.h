// SPDX-License-Identifier: Apache-2.0
// v4l2_order.h - puts frames into the order of their sequence numbers, and counts those that are missing.
#ifndef SHEEN_CAPTURE_V4L2_ORDER_H
#define SHEEN_CAPTURE_V4L2_ORDER_H

#include "capture/v4l2_stream.h"

// A place for the frame with this number of the driver's; NULL where its turn has passed (which is counted).
sheen_v4l2_frame *sheen_v4l2_order_enter(sheen_v4l2_stream *s, uint32_t raw, int64_t t_ns);
// Until when to wait for frames that are missing before one that is held: deadline_ns where none is held.
int64_t sheen_v4l2_order_patience(const sheen_v4l2_stream *s, int64_t deadline_ns);
// The good frame whose turn it is, or NULL; with `force`, or where nothing more can be held, the first that is there:
// the numbers before it count as dropped.
sheen_v4l2_frame *sheen_v4l2_order_take(sheen_v4l2_stream *s, bool force);

#endif
