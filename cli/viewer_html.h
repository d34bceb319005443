// SPDX-License-Identifier: Apache-2.0
// viewer_html.h - the web viewer that was built into the program (view/), as page_html wants it.
#ifndef SHEEN_CLI_VIEWER_HTML_H
#define SHEEN_CLI_VIEWER_HTML_H

extern const char sheen_viewer_html[]; // "": this build has no viewer
extern const char sheen_pick_html[];   // the page of `sheen register --pick`; likewise

#endif
