// SPDX-License-Identifier: Apache-2.0
// fake_sensor.h - what the fake camera's files share: its controls, and the picture that they make.
#ifndef SHEEN_TESTS_FAKE_FAKE_SENSOR_H
#define SHEEN_TESTS_FAKE_FAKE_SENSOR_H

#include "tests/fake/fake_v4l2.h"

struct v4l2_queryctrl;
struct v4l2_control;

void fake_add_controls(fake_v4l2 *f);
// 0 or errno.
int fake_query_control(fake_v4l2 *f, struct v4l2_queryctrl *q);
int fake_access_control(fake_v4l2 *f, struct v4l2_control *c, bool write);
// One frame period is over: the frame goes into a queued buffer, if there is one.
void fake_expose(fake_v4l2 *f);

#endif
