// SPDX-License-Identifier: Apache-2.0
// doctor_machine.c - what may be wrong with the machine: drivers, udev, other programs, memory.
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/file.h"
#include "cli/doctor.h"

static void under(char path[SHEEN_PATH_MAX], const char *root, const char *name)
{
    snprintf(path, SHEEN_PATH_MAX, "%.1000s%.2000s", root, name);
}

static bool is_there(const char *root, const char *name)
{
    char path[SHEEN_PATH_MAX];
    under(path, root, name);
    return !access(path, F_OK);
}

// The first line of a small file of the kernel's; "" where it cannot be read.
static void first_line(char line[128], const char *path)
{
    FILE *f = fopen(path, "r");
    line[0] = 0;
    if (!f)
        return;
    if (!fgets(line, 128, f))
        line[0] = 0;
    line[strcspn(line, "\n")] = 0;
    fclose(f);
}

// How many entries of a folder have a file `name` whose first line is `content`.
static size_t count_with(const char *root, const char *folder, const char *name, const char *content)
{
    char path[SHEEN_PATH_MAX], line[128];
    size_t n = 0;
    under(path, root, folder);
    DIR *d = opendir(path);
    if (!d)
        return 0;
    for (const struct dirent *e; (e = readdir(d));) {
        char file[SHEEN_PATH_MAX];
        if (e->d_name[0] == '.' ||
            snprintf(file, sizeof file, "%.3000s/%.255s/%.100s", path, e->d_name, name) >= (int)sizeof file)
            continue;
        first_line(line, file);
        n += !strcmp(line, content);
    }
    closedir(d);
    return n;
}

static void check_drivers(sheen_cli_findings *f, const char *root, size_t n_devices)
{
    static const char about[] = "cameras";
    const size_t n_plugged = count_with(root, "/sys/bus/usb/devices", "bInterfaceClass", "0e");
    if (n_devices)
        sheen_cli_found(f, SHEEN_CLI_FINE, about, "%zu found", n_devices);
    else if (n_plugged && !is_there(root, "/sys/bus/usb/drivers/uvcvideo"))
        sheen_cli_found(f, SHEEN_CLI_WRONG, about,
                        "a USB camera is plugged in, and its driver is not loaded: 'modprobe uvcvideo'");
    else if (n_plugged)
        sheen_cli_found(
            f, SHEEN_CLI_WRONG, about,
            "a USB camera is plugged in, and has no node under /dev: 'dmesg' says why the driver refused it");
    else
        sheen_cli_found(f, SHEEN_CLI_WRONG, about, "none is plugged in");
}

static void check_udev(sheen_cli_findings *f, const char *root)
{
    static const char *const rules[] = {
        "/etc/udev/rules.d/60-sheen.rules", "/run/udev/rules.d/60-sheen.rules",
        "/usr/local/lib/udev/rules.d/60-sheen.rules", "/usr/lib/udev/rules.d/60-sheen.rules",
        "/lib/udev/rules.d/60-sheen.rules"};
    bool installed = false;
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        installed = installed || is_there(root, rules[i]);
    if (!is_there(root, "/run/udev/control"))
        sheen_cli_found(
            f, SHEEN_CLI_NOTE, "udev",
            "udevd does not run: cameras have no lasting names, and one that comes back is noticed late");
    else if (installed)
        sheen_cli_found(f, SHEEN_CLI_FINE, "udev", "sheen's rules are installed");
    else
        sheen_cli_found(
            f, SHEEN_CLI_NOTE, "udev",
            "sheen's rules are not installed: a camera that hangs cannot be reset without root's rights");
    if (!installed && count_with(root, "/proc", "comm", "ModemManager"))
        sheen_cli_found(
            f, SHEEN_CLI_NOTE, "ModemManager",
            "it runs, and talks to every new serial port, turntables too: install sheen's udev rules");
}

static void check_memory(sheen_cli_findings *f, const char *root)
{
    char path[SHEEN_PATH_MAX], line[128];
    double available_mb = 0;
    under(path, root, "/proc/meminfo");
    FILE *file = fopen(path, "r");
    if (!file)
        return;
    while (fgets(line, sizeof line, file))
        if (!strncmp(line, "MemAvailable:", 13))
            available_mb = strtod(line + 13, NULL) / 1e3;
    fclose(file);
    if (available_mb < 1000)
        sheen_cli_found(f, SHEEN_CLI_NOTE, "memory", "%.0f MB are free: fitting wants one to four gigabytes",
                        available_mb);
    else
        sheen_cli_found(f, SHEEN_CLI_FINE, "memory", "%.1f GB are free", available_mb / 1e3);
}

void sheen_cli_check_machine(sheen_cli_findings *f, const char *root, size_t n_devices)
{
    check_drivers(f, root, n_devices);
    check_udev(f, root);
    check_memory(f, root);
}
