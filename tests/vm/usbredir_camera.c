// SPDX-License-Identifier: Apache-2.0
// usbredir_camera.c - the simulated camera behind qemu's own USB controller, from outside of the machine:
//
//     usbredir_camera SESSION SOCKET PLUGGED      plugged in as long as the file PLUGGED exists
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <sys/socket.h>
#include <sys/un.h>

#include <usbredirparser.h>

#include "tests/vm/uvc_camera.h"

enum { MAX_PENDING = 256, BULK_IN = 16 + 1 }; // endpoint 0x81's place in the lists of endpoints

static struct {
    uvc_camera camera;
    struct usbredirparser *parser;
    int fd;
    bool greeted;
    struct {
        uint64_t id;
        struct usb_redir_bulk_packet_header header;
    } pending[MAX_PENDING];
    int n_pending;
} host;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static void ignore_log(void *self, int level, const char *text)
{
    (void)self;
    if (level <= usbredirparser_warning)
        fprintf(stderr, "usbredir: %s\n", text);
}

static int read_some(void *self, uint8_t *data, int count)
{
    (void)self;
    const ssize_t n = recv(host.fd, data, (size_t)count, MSG_DONTWAIT);
    if (n < 0 && errno == EAGAIN)
        return 0;
    return n <= 0 ? -1 : (int)n;
}

static int write_some(void *self, uint8_t *data, int count)
{
    (void)self;
    const ssize_t n = send(host.fd, data, (size_t)count, MSG_NOSIGNAL);
    return n < 0 ? -1 : (int)n;
}

static void on_hello(void *self, struct usb_redir_hello_header *hello)
{
    struct usb_redir_interface_info_header interfaces = {.interface_count = 2,
                                                         .interface = {0, 1},
                                                         .interface_class = {0x0e, 0x0e},
                                                         .interface_subclass = {1, 2}};
    struct usb_redir_ep_info_header endpoints;
    struct usb_redir_device_connect_header device = {.speed = usb_redir_speed_high,
                                                     .device_class = 0xef,
                                                     .device_subclass = 2,
                                                     .device_protocol = 1,
                                                     .vendor_id = 0x1d6b,
                                                     .product_id = 0x0102,
                                                     .device_version_bcd = 0x0100};
    (void)self;
    (void)hello;
    memset(&endpoints, 0, sizeof endpoints);
    memset(endpoints.type, usb_redir_type_invalid, sizeof endpoints.type);
    endpoints.type[0] = endpoints.type[16] = usb_redir_type_control;
    endpoints.max_packet_size[0] = endpoints.max_packet_size[16] = 64;
    endpoints.type[BULK_IN] = usb_redir_type_bulk;
    endpoints.interface[BULK_IN] = 1;
    endpoints.max_packet_size[BULK_IN] = UVC_PACKET_BYTES;
    usbredirparser_send_interface_info(host.parser, &interfaces);
    usbredirparser_send_ep_info(host.parser, &endpoints);
    usbredirparser_send_device_connect(host.parser, &device);
    host.greeted = true;
}

static void on_reset(void *self)
{
    (void)self;
    host.camera.streaming = false;
    host.n_pending = 0;
}

static void on_set_configuration(void *self, uint64_t id, struct usb_redir_set_configuration_header *h)
{
    struct usb_redir_configuration_status_header answer = {usb_redir_success, h->configuration};
    (void)self;
    usbredirparser_send_configuration_status(host.parser, id, &answer);
}

static void on_get_configuration(void *self, uint64_t id)
{
    struct usb_redir_configuration_status_header answer = {usb_redir_success, 1};
    (void)self;
    usbredirparser_send_configuration_status(host.parser, id, &answer);
}

static void on_set_alt_setting(void *self, uint64_t id, struct usb_redir_set_alt_setting_header *h)
{
    struct usb_redir_alt_setting_status_header answer = {usb_redir_success, h->interface, h->alt};
    (void)self;
    usbredirparser_send_alt_setting_status(host.parser, id, &answer);
}

static void on_get_alt_setting(void *self, uint64_t id, struct usb_redir_get_alt_setting_header *h)
{
    struct usb_redir_alt_setting_status_header answer = {usb_redir_success, h->interface, 0};
    (void)self;
    usbredirparser_send_alt_setting_status(host.parser, id, &answer);
}

static void on_control(void *self, uint64_t id, struct usb_redir_control_packet_header *h, uint8_t *data,
                       int n_data)
{
    const uint8_t setup[8] = {h->requesttype,     h->request,
                              (uint8_t)h->value,  (uint8_t)(h->value >> 8),
                              (uint8_t)h->index,  (uint8_t)(h->index >> 8),
                              (uint8_t)h->length, (uint8_t)(h->length >> 8)};
    uint8_t buffer[4096] = {0};
    const bool in = h->requesttype & 0x80;
    (void)self;
    if (data && n_data > 0 && (size_t)n_data <= sizeof buffer)
        memcpy(buffer, data, (size_t)n_data);
    usbredirparser_free_packet_data(host.parser, data);
    const int n = h->length > sizeof buffer ? UVC_STALL
                                            : uvc_camera_setup(&host.camera, setup, buffer, now_ns());
    h->status = n < 0 ? usb_redir_stall : usb_redir_success;
    h->length = n < 0 ? 0 : in ? (uint16_t)n : h->length;
    usbredirparser_send_control_packet(host.parser, id, h, in && n > 0 ? buffer : NULL, in && n > 0 ? n : 0);
}

static void on_bulk(void *self, uint64_t id, struct usb_redir_bulk_packet_header *h, uint8_t *data,
                    int n_data)
{
    (void)self;
    (void)n_data;
    usbredirparser_free_packet_data(host.parser, data);
    if (host.n_pending == MAX_PENDING)
        exit(1);
    host.pending[host.n_pending].id = id;
    host.pending[host.n_pending++].header = *h;
}

static void answer_bulk(int i, uint8_t status, uint8_t *data, size_t n)
{
    struct usb_redir_bulk_packet_header h = host.pending[i].header;
    const uint64_t id = host.pending[i].id;
    memmove(&host.pending[i], &host.pending[i + 1], (size_t)(--host.n_pending - i) * sizeof host.pending[0]);
    h.status = status;
    h.length = (uint16_t)n;
    h.length_high = (uint16_t)(n >> 16);
    usbredirparser_send_bulk_packet(host.parser, id, &h, data, (int)n);
}

static void on_cancel(void *self, uint64_t id)
{
    (void)self;
    for (int i = 0; i < host.n_pending; i++)
        if (host.pending[i].id == id) {
            answer_bulk(i, usb_redir_cancelled, NULL, 0);
            return;
        }
}

static void send_due(void)
{
    static uint8_t data[UVC_TRANSFER_BYTES];
    while (host.n_pending) {
        const size_t asked = host.pending[0].header.length | (size_t)host.pending[0].header.length_high << 16;
        const size_t n = uvc_camera_transfer(&host.camera, data, asked < sizeof data ? asked : sizeof data,
                                             now_ns());
        if (!n)
            return;
        answer_bulk(0, usb_redir_success, data, n);
    }
}

static struct usbredirparser *make_parser(void)
{
    uint32_t caps[USB_REDIR_CAPS_SIZE] = {0};
    struct usbredirparser *p = usbredirparser_create();
    if (!p)
        exit(1);
    p->log_func = ignore_log;
    p->read_func = read_some;
    p->write_func = write_some;
    p->hello_func = on_hello;
    p->reset_func = on_reset;
    p->set_configuration_func = on_set_configuration;
    p->get_configuration_func = on_get_configuration;
    p->set_alt_setting_func = on_set_alt_setting;
    p->get_alt_setting_func = on_get_alt_setting;
    p->control_packet_func = on_control;
    p->bulk_packet_func = on_bulk;
    p->cancel_data_packet_func = on_cancel;
    usbredirparser_caps_set_cap(caps, usb_redir_cap_connect_device_version);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_ep_info_max_packet_size);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_64bits_ids);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_32bits_bulk_length);
    usbredirparser_init(p, "simulated camera", caps, USB_REDIR_CAPS_SIZE, usbredirparser_fl_usb_host);
    return p;
}

static bool plug(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    host.fd = socket(AF_UNIX, SOCK_STREAM, 0);
    if (connect(host.fd, (const void *)&address, sizeof address)) {
        close(host.fd);
        return false;
    }
    host.parser = make_parser();
    host.camera.streaming = host.greeted = false;
    host.n_pending = 0;
    return true;
}

static void serve_while(const char *plugged)
{
    while (!access(plugged, F_OK)) {
        struct pollfd wait = {.fd = host.fd, .events = POLLIN};
        const int64_t left_ns = host.camera.next_ns - now_ns();
        const bool due = host.n_pending && host.camera.streaming;
        poll(&wait, 1, due ? (left_ns > 0 ? (int)(left_ns / 1000000) + 1 : 0) : 100);
        if (wait.revents && usbredirparser_do_read(host.parser) < 0)
            break;
        send_due();
        while (usbredirparser_has_data_to_write(host.parser))
            if (usbredirparser_do_write(host.parser) < 0)
                break;
    }
    usbredirparser_destroy(host.parser);
    close(host.fd);
}

int main(int argc, char **argv)
{
    const struct timespec a_little = {0, 50000000};
    if (argc != 4 || !uvc_camera_init(&host.camera, argv[1]))
        return 2;
    for (;;) {
        nanosleep(&a_little, NULL);
        if (!access(argv[3], F_OK) && plug(argv[2]))
            serve_while(argv[3]);
    }
}
