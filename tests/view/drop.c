// Drops a file on a window, as a file manager does: drop WINDOW FILE. The source's side of version 5 of the
// XDND protocol (freedesktop.org), without a pointer to drag: the messages are sent as if it were there.
#include <X11/Xatom.h>
#include <X11/Xlib.h>

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATIENCE_MS 60000

enum atom { ENTER, POSITION, STATUS, DROP, FINISHED, SELECTION, ACTION_COPY, URI_LIST, ATOMS };
static const char *const names[ATOMS] = {"XdndEnter",    "XdndPosition",  "XdndStatus",     "XdndDrop",
                                         "XdndFinished", "XdndSelection", "XdndActionCopy", "text/uri-list"};

struct drag {
    Display *display;
    Window source, target;
    Atom atoms[ATOMS];
    char uri[4200];
};

static void tell(const struct drag *d, enum atom what, long a, long b, long c, long e)
{
    XEvent event = {.xclient = {.type = ClientMessage,
                                .window = d->target,
                                .message_type = d->atoms[what],
                                .format = 32,
                                .data.l = {(long)d->source, a, b, c, e}}};
    XSendEvent(d->display, d->target, False, NoEventMask, &event);
    XFlush(d->display);
}

// Gives whoever asks the list of files, which is one.
static void answer(const struct drag *d, const XSelectionRequestEvent *asked)
{
    XChangeProperty(d->display, asked->requestor, asked->property, d->atoms[URI_LIST], 8, PropModeReplace,
                    (const unsigned char *)d->uri, (int)strlen(d->uri));
    XEvent event = {.xselection = {.type = SelectionNotify,
                                   .requestor = asked->requestor,
                                   .selection = asked->selection,
                                   .target = asked->target,
                                   .property = asked->property,
                                   .time = asked->time}};
    XSendEvent(d->display, asked->requestor, False, NoEventMask, &event);
    XFlush(d->display);
}

// Until the target says that it has taken what was dropped. False: it does not want it, or says nothing.
static int serve(const struct drag *d)
{
    struct pollfd connection = {.fd = ConnectionNumber(d->display), .events = POLLIN};
    for (;;) {
        XEvent event;
        if (!XPending(d->display) && poll(&connection, 1, PATIENCE_MS) <= 0)
            return 0;
        XNextEvent(d->display, &event);
        if (event.type == SelectionRequest)
            answer(d, &event.xselectionrequest);
        if (event.type != ClientMessage)
            continue;
        if (event.xclient.message_type == d->atoms[STATUS]) {
            if (!(event.xclient.data.l[1] & 1))
                return 0;
            tell(d, DROP, 0, CurrentTime, 0, 0);
        }
        if (event.xclient.message_type == d->atoms[FINISHED])
            return event.xclient.data.l[1] != 0; // GLFW says how many bytes it got
    }
}

int main(int argc, char **argv)
{
    struct drag d = {.display = XOpenDisplay(NULL)};
    if (argc != 3 || !d.display) {
        fputs("usage: drop WINDOW FILE, on a display\n", stderr);
        return 2;
    }
    d.target = strtoul(argv[1], NULL, 0);
    snprintf(d.uri, sizeof d.uri, "file://%s\r\n", argv[2]);
    for (int i = 0; i < ATOMS; i++)
        d.atoms[i] = XInternAtom(d.display, names[i], False);
    d.source = XCreateSimpleWindow(d.display, DefaultRootWindow(d.display), 0, 0, 1, 1, 0, 0, 0);
    XSetSelectionOwner(d.display, d.atoms[SELECTION], d.source, CurrentTime);
    tell(&d, ENTER, 5L << 24, (long)d.atoms[URI_LIST], 0, 0);
    tell(&d, POSITION, 0, 10L << 16 | 10, CurrentTime, (long)d.atoms[ACTION_COPY]);
    int taken = serve(&d);
    XCloseDisplay(d.display);
    return taken ? 0 : 1;
}
