// SPDX-License-Identifier: Apache-2.0
// record_queue.h - the recorder's writer: a thread that puts frames on the disk, behind a queue of bounded size.
//
// The recorder's thread pushes copies of frames and collects what became of them; the session's list of frames stays its
// own. After the first frame that cannot be written the others in the queue are not tried any more.
#ifndef SHEEN_CAPTURE_RECORD_QUEUE_H
#define SHEEN_CAPTURE_RECORD_QUEUE_H

#include "capture/record.h"

typedef struct sheen_record_queue sheen_record_queue;

// Starts the writer. At most limit_bytes of payloads wait (one frame always may); the session's path must stay. ENOMEM.
sheen_status sheen_record_queue_open(sheen_record_queue **out, const sheen_session *session,
                                     const sheen_record_options *options, sheen_err *err);
// Ends the writer, which first writes what waits (unless a write has failed), and frees everything.
void sheen_record_queue_close(sheen_record_queue **q);

// Waits at most timeout_ms until there is room for a frame of that size. ETIMEOUT leaves err alone.
bool sheen_record_queue_wait_room(sheen_record_queue *q, size_t size_bytes, int timeout_ms);
// Puts a copy of the frame, whose name is set, at the end, room or not. ENOMEM.
sheen_status sheen_record_queue_push(sheen_record_queue *q, const sheen_frame *frame, sheen_err *err);
// Waits at most timeout_ms for the end of the oldest frame's writing. *info is it as it was written, or, with the reason,
// as it should have been. ETIMEOUT leaves err alone: none is ready.
sheen_status sheen_record_queue_collect(sheen_record_queue *q, sheen_frame_info *info, int timeout_ms,
                                        sheen_err *err);
// Frames pushed and not yet collected.
size_t sheen_record_queue_count(const sheen_record_queue *q);

#endif
