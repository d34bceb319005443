// SPDX-License-Identifier: Apache-2.0
// libcamera_source.cc - libcamera:N or libcamera:ID, a camera of libcamera as a source; the one file that includes it.
//
// Requests with a buffer each go round: queued, finished by libcamera's thread, handed over (libcamera_inbox.h), copied,
// judged by their metadata (libcamera_frames.h), and queued again with the settings of the lock (libcamera_lock.h). A
// camera that is unplugged just stalls: its `disconnected` signal ends the waiting; it is found again by its id, and locked
// and proven anew. Written for the interface of 0.0.3; what is different in newer ones is in the block below.
#include "capture/libcamera_source.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <sys/mman.h>

#include <linux/videodev2.h>

#include <libcamera/camera.h>
#include <libcamera/camera_manager.h>
#include <libcamera/control_ids.h>
#include <libcamera/formats.h>
#include <libcamera/framebuffer_allocator.h>
#include <libcamera/logging.h>
#include <libcamera/property_ids.h>
#include <libcamera/request.h>

#include "base/clock.h"
#include "capture/libcamera_frames.h"
#include "capture/libcamera_inbox.h"
#include "capture/source_backend.h"
#include "capture/v4l2_options.h"

namespace lc = libcamera;
namespace formats = libcamera::formats;
namespace controls = libcamera::controls;

namespace
{

// What differs between versions of libcamera.
using roles = std::vector<lc::StreamRole>; // 0.0.3 wants this very type, newer ones a span, which it becomes
using metadata = const lc::ControlList &;  // of a request: const since 0.4

struct format_name {
    lc::PixelFormat theirs;
    uint32_t ours;
    bool raw;
};

constexpr format_name known_formats[] = {
    {formats::YUYV, V4L2_PIX_FMT_YUYV, false},
    {formats::NV12, V4L2_PIX_FMT_NV12, false},
    {formats::MJPEG, V4L2_PIX_FMT_MJPEG, false},
    {formats::R8, V4L2_PIX_FMT_GREY, false},
    {formats::BGR888, V4L2_PIX_FMT_RGB24, false}, // named from the other end
    {formats::RGB888, V4L2_PIX_FMT_BGR24, false},
    {formats::SBGGR8, V4L2_PIX_FMT_SBGGR8, true},
    {formats::SGBRG8, V4L2_PIX_FMT_SGBRG8, true},
    {formats::SGRBG8, V4L2_PIX_FMT_SGRBG8, true},
    {formats::SRGGB8, V4L2_PIX_FMT_SRGGB8, true},
    {formats::SBGGR10, V4L2_PIX_FMT_SBGGR10, true},
    {formats::SGBRG10, V4L2_PIX_FMT_SGBRG10, true},
    {formats::SGRBG10, V4L2_PIX_FMT_SGRBG10, true},
    {formats::SRGGB10, V4L2_PIX_FMT_SRGGB10, true},
    {formats::SBGGR10_CSI2P, V4L2_PIX_FMT_SBGGR10P, true},
    {formats::SGBRG10_CSI2P, V4L2_PIX_FMT_SGBRG10P, true},
    {formats::SGRBG10_CSI2P, V4L2_PIX_FMT_SGRBG10P, true},
    {formats::SRGGB10_CSI2P, V4L2_PIX_FMT_SRGGB10P, true},
    {formats::SBGGR12, V4L2_PIX_FMT_SBGGR12, true},
    {formats::SGBRG12, V4L2_PIX_FMT_SGBRG12, true},
    {formats::SGRBG12, V4L2_PIX_FMT_SGRBG12, true},
    {formats::SRGGB12, V4L2_PIX_FMT_SRGGB12, true},
    {formats::SBGGR12_CSI2P, V4L2_PIX_FMT_SBGGR12P, true},
    {formats::SGBRG12_CSI2P, V4L2_PIX_FMT_SGBRG12P, true},
    {formats::SGRBG12_CSI2P, V4L2_PIX_FMT_SGRBG12P, true},
    {formats::SRGGB12_CSI2P, V4L2_PIX_FMT_SRGGB12P, true},
    {formats::SBGGR16, V4L2_PIX_FMT_SBGGR16, true},
    {formats::SGBRG16, V4L2_PIX_FMT_SGBRG16, true},
    {formats::SGRBG16, V4L2_PIX_FMT_SGRBG16, true},
    {formats::SRGGB16, V4L2_PIX_FMT_SRGGB16, true},
};

const format_name *find_ours(uint32_t fourcc)
{
    for (const format_name &f : known_formats)
        if (f.ours == fourcc)
            return &f;
    return nullptr;
}

const format_name *find_theirs(const lc::PixelFormat &format)
{
    for (const format_name &f : known_formats)
        if (f.theirs == format)
            return &f;
    return nullptr;
}

struct mapping {
    uint8_t *at = nullptr;
    size_t size_bytes = 0;
};

struct camera {
    sheen_v4l2_options options{};
    std::string name; // for sentences
    std::string id;   // libcamera's, by which it is found again; "" before it was found
    std::unique_ptr<lc::CameraManager> manager;
    std::shared_ptr<lc::Camera> device;
    std::unique_ptr<lc::CameraConfiguration> configuration;
    std::unique_ptr<lc::FrameBufferAllocator> buffers;
    std::vector<std::unique_ptr<lc::Request>> requests;
    std::map<int, mapping> mappings; // by file
    bool acquired = false, started = false;
    sheen_libcamera_frames frames{};
    std::vector<uint8_t> payload; // lent
    sheen_libcamera_inbox *inbox = nullptr;

    void on_completed(lc::Request *request)
    {
        if (request->status() != lc::Request::RequestCancelled)
            sheen_libcamera_inbox_put(inbox, request);
    }

    void on_disconnected()
    {
        sheen_libcamera_inbox_unplug(inbox);
    }

    camera() = default;
    camera(const camera &) = delete;
    camera &operator=(const camera &) = delete;

    // Everything of the device is given back, in any state; the manager goes on and sees it come again.
    void let_go()
    {
        if (device) {
            if (started)
                device->stop();
            device->requestCompleted.disconnect(this);
            device->disconnected.disconnect(this);
        }
        requests.clear();
        for (const auto &m : mappings)
            munmap(m.second.at, m.second.size_bytes);
        mappings.clear();
        buffers.reset();
        if (acquired)
            device->release();
        configuration.reset();
        device.reset();
        acquired = started = false;
        if (inbox)
            sheen_libcamera_inbox_clear(inbox);
    }

    ~camera()
    {
        let_go();
        if (manager)
            manager->stop();
        sheen_libcamera_inbox_close(&inbox);
    }
};

sheen_status start_manager(std::unique_ptr<lc::CameraManager> &manager, sheen_err *err)
{
    lc::logSetTarget(lc::LoggingTargetNone);
    manager = std::make_unique<lc::CameraManager>();
    if (manager->start() == 0)
        return SHEEN_OK;
    manager.reset();
    return sheen_fail(err, SHEEN_EIO, "libcamera does not start: does udev run here?");
}

std::string model_of(const lc::Camera &device)
{
    const auto model = device.properties().get(lc::properties::Model);
    return model ? std::string(*model) : device.id();
}

// "0", or an id as `sheen devices` lists it.
sheen_status find_device(camera &c, sheen_err *err)
{
    const auto all = c.manager->cameras();
    const std::string wanted = c.id.empty() ? c.options.path : c.id;
    char *end;
    const unsigned long i = strtoul(wanted.c_str(), &end, 10);
    if (c.id.empty() && !*end && i < all.size()) // a number says which one at the beginning only
        c.device = all[i];
    for (const auto &device : all)
        if (device->id() == wanted)
            c.device = device;
    if (!c.device)
        return sheen_fail(err, SHEEN_ENODEV,
                          "libcamera knows %zu cameras, and '%.100s' is none: 'sheen devices' lists them",
                          all.size(), wanted.c_str());
    c.name = model_of(*c.device);
    c.id = c.device->id();
    if (c.device->acquire())
        return sheen_fail(err, SHEEN_EIO, "cannot use '%.80s': another program does; close it and try again",
                          c.name.c_str());
    c.acquired = true;
    return SHEEN_OK;
}

sheen_status fail_requests(const camera &c, sheen_err *err)
{
    return sheen_fail(err, SHEEN_EIO, "'%.80s' takes no requests", c.name.c_str());
}

sheen_status fail_format(const camera &c, const lc::StreamConfiguration &got, sheen_err *err)
{
    return sheen_fail(err, SHEEN_EUNSUP, "'%.80s' does not offer that: it would give %.80s", c.name.c_str(),
                      got.toString().c_str());
}

// In V4L2's numbers, as far as libcamera says it.
sheen_colorimetry colorimetry_of(const lc::StreamConfiguration &stream)
{
    sheen_colorimetry c = {V4L2_COLORSPACE_SRGB, 0, 0, 0};
    if (!stream.colorSpace)
        return c;
    const lc::ColorSpace &s = *stream.colorSpace;
    if (s.primaries == lc::ColorSpace::Primaries::Raw)
        c.colorspace = V4L2_COLORSPACE_RAW;
    else if (s.primaries == lc::ColorSpace::Primaries::Smpte170m)
        c.colorspace = V4L2_COLORSPACE_SMPTE170M;
    else if (s.primaries == lc::ColorSpace::Primaries::Rec2020)
        c.colorspace = V4L2_COLORSPACE_BT2020;
    c.xfer_func = s.transferFunction == lc::ColorSpace::TransferFunction::Linear ? V4L2_XFER_FUNC_NONE
                  : s.transferFunction == lc::ColorSpace::TransferFunction::Srgb ? V4L2_XFER_FUNC_SRGB
                                                                                 : V4L2_XFER_FUNC_709;
    c.ycbcr_enc = s.ycbcrEncoding == lc::ColorSpace::YcbcrEncoding::Rec601    ? V4L2_YCBCR_ENC_601
                  : s.ycbcrEncoding == lc::ColorSpace::YcbcrEncoding::Rec709  ? V4L2_YCBCR_ENC_709
                  : s.ycbcrEncoding == lc::ColorSpace::YcbcrEncoding::Rec2020 ? V4L2_YCBCR_ENC_BT2020
                                                                              : 0;
    c.quantization = s.range == lc::ColorSpace::Range::Full ? V4L2_QUANTIZATION_FULL_RANGE
                                                            : V4L2_QUANTIZATION_LIM_RANGE;
    return c;
}

sheen_status configure(camera &c, sheen_err *err)
{
    const format_name *wanted = find_ours(c.options.fourcc);
    if (c.options.fourcc && !wanted)
        return sheen_fail(err, SHEEN_EUNSUP, "that format is none of those that sheen takes from libcamera");
    const roles one = {wanted && wanted->raw ? lc::StreamRole::Raw : lc::StreamRole::VideoRecording};
    c.configuration = c.device->generateConfiguration(one);
    if (!c.configuration || c.configuration->empty())
        return sheen_fail(err, SHEEN_EUNSUP, "'%.80s' gives no %s through libcamera", c.name.c_str(),
                          wanted && wanted->raw ? "raw frames" : "pictures");
    lc::StreamConfiguration &stream = c.configuration->at(0);
    if (wanted)
        stream.pixelFormat = wanted->theirs;
    if (c.options.width_px)
        stream.size = lc::Size(unsigned(c.options.width_px), unsigned(c.options.height_px));
    stream.bufferCount = 4;
    if (c.configuration->validate() == lc::CameraConfiguration::Invalid)
        return fail_format(c, stream, err);
    const format_name *got = find_theirs(stream.pixelFormat);
    if (!got || (wanted && got != wanted) ||
        (c.options.width_px &&
         stream.size != lc::Size(unsigned(c.options.width_px), unsigned(c.options.height_px))))
        return fail_format(c, stream, err);
    if (c.device->configure(c.configuration.get()))
        return sheen_fail(err, SHEEN_EIO, "'%.80s' cannot be configured", c.name.c_str());
    c.frames.lock.is_raw = got->raw;
    sheen_frame_info &info = c.frames.info;
    info.fourcc = got->ours == V4L2_PIX_FMT_MJPEG ? 0 : got->ours;
    info.width_px = int(stream.size.width);
    info.height_px = int(stream.size.height);
    info.stride_bytes = info.fourcc ? int(stream.stride) : 0;
    info.color = colorimetry_of(stream);
    if (!info.fourcc) // what libcamera puts in where USB video says nothing is no word on a JPEG's range
        info.color.quantization = V4L2_QUANTIZATION_DEFAULT;
    sheen_v4l2_options_color(&info.color, &c.options);
    return SHEEN_OK;
}

sheen_status describe(camera &c, sheen_err *err)
{
    const std::string claim = c.configuration->at(0).toString();
    return sheen_libcamera_frames_describe(&c.frames, c.name.c_str(), c.id.c_str(), claim.c_str(),
                                           c.options.set_transfer ? &c.options.transfer : nullptr, err);
}

// Planes of one buffer may share a file: each file is mapped once, as far as its planes reach.
sheen_status map_buffers(camera &c, sheen_err *err)
{
    std::map<int, size_t> reach;
    for (const auto &buffer : c.buffers->buffers(c.configuration->at(0).stream()))
        for (const lc::FrameBuffer::Plane &plane : buffer->planes()) {
            size_t &bytes = reach[plane.fd.get()];
            const size_t offset = plane.offset == lc::FrameBuffer::Plane::kInvalidOffset ? 0 : plane.offset;
            bytes = std::max(bytes, offset + plane.length);
        }
    for (const auto &r : reach) {
        void *at = mmap(nullptr, r.second, PROT_READ, MAP_SHARED, r.first, 0);
        if (at == MAP_FAILED)
            return sheen_fail(err, SHEEN_EIO, "the buffers of '%.80s' cannot be mapped: %s", c.name.c_str(),
                              strerror(errno));
        c.mappings[r.first] = {static_cast<uint8_t *>(at), r.second};
    }
    return SHEEN_OK;
}

// (count() of 0.0.3 answers for all controls that there are, not for those of the camera.)
bool has(const lc::ControlInfoMap &can, const lc::ControlId &control)
{
    return can.find(control.id()) != can.end();
}

// What every request asks for: nothing while the automatics find their values, then those.
void ask(const camera &c, lc::ControlList &list)
{
    const lc::ControlInfoMap &can = c.device->controls();
    if (!c.frames.locked || c.frames.lock.phase == SHEEN_LIBCAMERA_WARM_UP)
        return;
    if (has(can, controls::AeEnable))
        list.set(controls::AeEnable, false);
    list.set(controls::ExposureTime, int32_t(std::lround(c.frames.lock.want.exposure_us)));
    list.set(controls::AnalogueGain, float(c.frames.lock.want.analogue_gain));
    if (c.frames.lock.is_raw)
        return;
    if (has(can, controls::AwbEnable))
        list.set(controls::AwbEnable, false);
    list.set(controls::ColourGains,
             {float(c.frames.lock.want.red_gain), float(c.frames.lock.want.blue_gain)});
}

sheen_status start(camera &c, sheen_err *err)
{
    lc::Stream *stream = c.configuration->at(0).stream();
    c.buffers = std::make_unique<lc::FrameBufferAllocator>(c.device);
    const int n_buffers = c.buffers->allocate(stream);
    if (n_buffers <= 0 || n_buffers > SHEEN_LIBCAMERA_MAX_REQUESTS)
        return sheen_fail(err, SHEEN_ENOMEM, "'%.80s' has no memory for its frames: ask for a smaller size",
                          c.name.c_str());
    const sheen_status s = map_buffers(c, err);
    if (s)
        return s;
    c.device->requestCompleted.connect(&c, &camera::on_completed);
    c.device->disconnected.connect(&c, &camera::on_disconnected);
    lc::ControlList initial(c.device->controls());
    if (c.options.rate_hz > 0 && has(c.device->controls(), controls::FrameDurationLimits)) {
        const int64_t us = std::llround(1e6 / c.options.rate_hz);
        initial.set(controls::FrameDurationLimits, {us, us});
    }
    if (c.device->start(&initial))
        return sheen_fail(
            err, SHEEN_EIO,
            "'%.80s' does not start: is the USB bus full? Ask for MJPG, a smaller size or a lower rate",
            c.name.c_str());
    c.started = true;
    for (const auto &buffer : c.buffers->buffers(stream)) {
        std::unique_ptr<lc::Request> request = c.device->createRequest();
        if (!request || request->addBuffer(stream, buffer.get()))
            return fail_requests(c, err);
        ask(c, request->controls());
        if (c.device->queueRequest(request.get()))
            return fail_requests(c, err);
        c.requests.push_back(std::move(request));
    }
    return SHEEN_OK;
}

sheen_status begin_lock(camera &c, sheen_err *err)
{
    const lc::ControlInfoMap &can = c.device->controls();
    const sheen_libcamera_abilities abilities = {
        has(can, controls::ExposureTime), has(can, controls::AnalogueGain), has(can, controls::ColourGains)};
    return c.frames.locked ? sheen_libcamera_lock_begin(&c.frames.lock, &abilities, c.name.c_str(), err)
                           : SHEEN_OK;
}

// The device that was found, until it streams.
sheen_status make_ready(camera &c, sheen_err *err)
{
    sheen_status s = configure(c, err);
    if (!s)
        s = begin_lock(c, err);
    if (!s)
        s = describe(c, err);
    return s ? s : start(c, err);
}

sheen_status open_camera(camera &c, const char *rest, sheen_err *err)
{
    sheen_frame_info_init(&c.frames.info);
    sheen_status s = sheen_libcamera_inbox_open(&c.inbox, err);
    if (!s)
        s = sheen_v4l2_options_parse(&c.options, rest, err);
    if (!s)
        s = start_manager(c.manager, err);
    if (!s)
        s = find_device(c, err);
    c.frames.locked = c.options.lock;
    c.frames.lock.exposure_s = c.options.exposure_s;
    c.frames.lock.mains_hz = c.options.mains_hz;
    return s ? s : make_ready(c, err);
}

sheen_frame_pipeline read_metadata(metadata says)
{
    sheen_frame_pipeline p = {};
    if (const auto x = says.get(controls::ExposureTime))
        p.exposure_us = *x;
    if (const auto x = says.get(controls::AnalogueGain))
        p.analogue_gain = double(*x);
    if (const auto x = says.get(controls::DigitalGain))
        p.digital_gain = double(*x);
    if (const auto x = says.get(controls::ColourGains)) {
        p.red_gain = double((*x)[0]);
        p.blue_gain = double((*x)[1]);
    }
    if (const auto x = says.get(controls::SensorBlackLevels))
        for (size_t i = 0; i < 4; i++)
            p.black_levels[i] = (*x)[i];
    return p;
}

// The frame's bytes, plane after plane.
void copy_payload(camera &c, const lc::FrameBuffer &buffer)
{
    c.payload.clear();
    const auto &planes = buffer.planes();
    for (size_t i = 0; i < planes.size() && i < buffer.metadata().planes().size(); i++) {
        const mapping &m = c.mappings[planes[i].fd.get()];
        const size_t offset = planes[i].offset == lc::FrameBuffer::Plane::kInvalidOffset ? 0
                                                                                         : planes[i].offset;
        const size_t used = std::min<size_t>(buffer.metadata().planes()[i].bytesused, planes[i].length);
        c.payload.insert(c.payload.end(), m.at + offset, m.at + offset + used);
    }
}

// A finished request: *keep says whether its frame may be used.
sheen_status take(camera &c, lc::Request &request, sheen_frame *frame, bool *keep, sheen_err *err)
{
    const lc::FrameBuffer &buffer = *request.buffers().begin()->second;
    const lc::FrameMetadata &m = buffer.metadata();
    *keep = false;
    if (!sheen_libcamera_frames_turn(&c.frames, m.sequence, m.status == lc::FrameMetadata::FrameSuccess))
        return SHEEN_OK;
    copy_payload(c, buffer);
    const sheen_frame_pipeline says = read_metadata(request.metadata());
    const auto stamp = request.metadata().get(controls::SensorTimestamp);
    *frame = sheen_frame{};
    frame->data = c.payload.data();
    frame->size_bytes = c.payload.size();
    frame->info.t_ns = stamp ? *stamp : int64_t(m.timestamp);
    return sheen_libcamera_frames_judge(keep, frame, &c.frames, &says, c.name.c_str(), err);
}

sheen_status next_frame(camera &c, int timeout_ms, sheen_frame *frame, sheen_err *err)
{
    const int64_t deadline_ns = sheen_clock_ns() + int64_t(timeout_ms) * 1000000;
    for (;;) {
        void *finished = nullptr;
        bool keep;
        sheen_status s = sheen_libcamera_inbox_take(c.inbox, deadline_ns, c.name.c_str(), &finished, err);
        if (s)
            return s;
        lc::Request *request = static_cast<lc::Request *>(finished);
        s = take(c, *request, frame, &keep, err);
        if (s)
            return s;
        request->reuse(lc::Request::ReuseBuffers);
        ask(c, request->controls());
        const bool queued = c.device->queueRequest(request) ==
                            0; // not where it was unplugged: the signal tells
        if (keep)
            return SHEEN_OK;
        if (!queued && sheen_clock_ns() >= deadline_ns)
            return sheen_fail(err, SHEEN_EIO, "'%.80s' takes no requests any more", c.name.c_str());
    }
}

sheen_status fail_exception(sheen_err *err, const std::exception &e)
{
    return sheen_fail(err, SHEEN_ENOMEM, "libcamera failed: %.200s", e.what());
}

sheen_status backend_open(void **self_out, const char *rest, sheen_err *err)
try {
    auto c = std::make_unique<camera>();
    const sheen_status s = open_camera(*c, rest, err);
    if (!s)
        *self_out = c.release();
    return s;
} catch (const std::exception &e) {
    return fail_exception(err, e);
}

sheen_status backend_next(void *self, int timeout_ms, sheen_frame *frame, sheen_err *err)
try {
    return next_frame(*static_cast<camera *>(self), timeout_ms, frame, err);
} catch (const std::exception &e) {
    return fail_exception(err, e);
}

// The stream anew: what was queued comes back cancelled, and is queued again with the settings of the lock.
sheen_status restart(camera &c, sheen_err *err)
{
    if (!c.started || c.device->stop())
        return sheen_fail(err, SHEEN_EIO, "'%.80s' does not stop", c.name.c_str());
    c.started = false;
    if (sheen_libcamera_inbox_is_unplugged(c.inbox))
        return sheen_fail(err, SHEEN_ENODEV, "'%.80s' is gone", c.name.c_str());
    sheen_libcamera_inbox_clear(c.inbox);
    c.frames.begun = false; // it counts its frames from 0 again
    const sheen_status s = begin_lock(c, err);
    if (s)
        return s;
    if (c.device->start())
        return sheen_fail(err, SHEEN_EIO, "'%.80s' does not start again", c.name.c_str());
    c.started = true;
    for (const auto &request : c.requests) {
        request->reuse(lc::Request::ReuseBuffers);
        ask(c, request->controls());
        if (c.device->queueRequest(request.get()))
            return fail_requests(c, err);
    }
    return SHEEN_OK;
}

sheen_status reopen(camera &c, sheen_err *err)
{
    const sheen_colorimetry color = c.frames.info.color;
    c.let_go();
    c.frames.begun = false;
    sheen_status s = find_device(c, err);
    if (!s)
        s = make_ready(c, err);
    if (!s && memcmp(&color, &c.frames.info.color, sizeof color) != 0)
        s = sheen_fail(err, SHEEN_EIO, "'%.80s' came back with other colours: begin a new session",
                       c.name.c_str());
    return s;
}

sheen_status recover(camera &c, sheen_rung rung, sheen_err *err)
{
    if (rung == SHEEN_RUNG_RESET)
        return sheen_fail(err, SHEEN_EUNSUP, "libcamera resets no devices");
    return rung == SHEEN_RUNG_RESTART && c.started ? restart(c, err) : reopen(c, err);
}

// libcamera tells of cameras that come by signals of its own; a look at its list now and then does as well.
bool await(camera &c, int timeout_ms)
{
    c.let_go(); // whoever holds the old device keeps its place from the one that comes
    for (const auto &device : c.manager->cameras())
        if (device->id() == c.id)
            return true;
    sheen_libcamera_inbox_sleep(c.inbox, timeout_ms);
    return false;
}

sheen_status backend_recover(void *self, sheen_rung rung, sheen_err *err)
try {
    return recover(*static_cast<camera *>(self), rung, err);
} catch (const std::exception &e) {
    return fail_exception(err, e);
}

bool backend_await(void *self, int timeout_ms)
try {
    return await(*static_cast<camera *>(self), timeout_ms);
} catch (const std::exception &) {
    return false;
}

// Also called from a signal handler: a flag and a write.
void backend_stop(void *self)
{
    sheen_libcamera_inbox_stop(static_cast<camera *>(self)->inbox);
}

void backend_counters(sheen_source_counts *out, const void *self)
{
    *out = static_cast<const camera *>(self)->frames.counts;
}

void backend_close(void *self)
{
    delete static_cast<camera *>(self);
}

constexpr sheen_source_backend make_backend() noexcept
{
    sheen_source_backend b = {};
    b.scheme = "libcamera";
    b.open = backend_open;
    b.next = backend_next;
    b.stop = backend_stop;
    b.counters = backend_counters;
    b.recover = backend_recover;
    b.await = backend_await;
    b.close = backend_close;
    return b;
}

} // namespace

const sheen_source_backend sheen_source_libcamera = make_backend();

sheen_status sheen_libcamera_list(sheen_libcamera_name *names, int max_names, int *n_out, sheen_err *err)
try {
    std::unique_ptr<lc::CameraManager> manager;
    *n_out = 0;
    const sheen_status s = start_manager(manager, err);
    if (s)
        return s;
    {
        const auto all = manager->cameras();
        *n_out = int(all.size());
        for (int i = 0; i < *n_out && i < max_names; i++) {
            snprintf(names[i].id, sizeof names[i].id, "%s", all[size_t(i)]->id().c_str());
            snprintf(names[i].model, sizeof names[i].model, "%s", model_of(*all[size_t(i)]).c_str());
        }
    }
    manager->stop();
    return SHEEN_OK;
} catch (const std::exception &e) {
    return fail_exception(err, e);
}
