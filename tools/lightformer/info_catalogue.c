#include "info_catalogue.h"

#include "json.h"

#include "asset/catalogue.h"
#include "base/printable.h"

#include <string.h>

// What --json and SCENE#NAME take: the id's end, or the name where there is none.
static const char *short_name(const struct ng_piece *p)
{
    const char *hash = strrchr(p->id, '#');
    return hash && hash[1] ? hash + 1 : p->id[0] ? p->id : p->name;
}

static void print_piece(const struct ng_catalogue *c, const struct ng_piece *p)
{
    bool own = strcmp(p->license, c->license) != 0;
    ng_print_line(stdout, "  %-30s %-32s %5.2f x %5.2f x %5.2f m  %s%s%s%s", short_name(p), p->name,
                  (double)p->size[0], (double)p->size[1], (double)p->size[2],
                  p->creator[0] ? p->creator : "author not named", own ? ", " : "", own ? p->license : "",
                  p->door_or_window ? " (door or window)" : "");
}

static void print_catalogue(const struct ng_catalogue *c)
{
    ng_print_line(stdout, "%s", c->path);
    ng_print_line(stdout, "  %s%s%s, of %s", c->name[0] ? c->name : "a catalogue without name",
                  c->version[0] ? " " : "", c->version,
                  c->provider[0] ? c->provider : "a provider that it does not name");
    ng_print_line(stdout, "  license: %s", c->license[0] ? c->license : "not named");
    ng_print_line(stdout, "  %u pieces; %s#NAME is one: NAME, title, width x height x depth, author",
                  c->piece_count, c->path);
    for (uint32_t i = 0; i < c->piece_count; i++)
        print_piece(c, &c->pieces[i]);
}

static void write_piece(struct json *j, const struct ng_piece *p)
{
    json_object(j, NULL);
    json_text(j, "name", short_name(p));
    json_text(j, "id", p->id);
    json_text(j, "title", p->name);
    json_text(j, "category", p->category);
    json_text(j, "creator", p->creator);
    json_text(j, "license", p->license);
    json_text(j, "model", p->model);
    json_array(j, "size_m");
    for (int i = 0; i < 3; i++)
        json_number(j, NULL, (double)p->size[i]);
    json_end(j);
    json_number(j, "elevation_m", (double)p->elevation);
    json_bool(j, "movable", p->movable);
    json_bool(j, "door_or_window", p->door_or_window);
    json_end(j);
}

static void write_catalogue(const struct ng_catalogue *c)
{
    struct json j = {.out = stdout};
    json_object(&j, NULL);
    json_text(&j, "catalogue", c->path);
    json_text(&j, "title", c->name);
    json_text(&j, "version", c->version);
    json_text(&j, "provider", c->provider);
    json_text(&j, "license", c->license);
    json_array(&j, "pieces");
    for (uint32_t i = 0; i < c->piece_count; i++)
        write_piece(&j, &c->pieces[i]);
    json_end(&j);
    json_end(&j);
}

ng_result info_catalogue(const char *path, bool json)
{
    struct ng_catalogue *catalogue;
    NG_TRY(ng_catalogue_open(path, 0, &catalogue));
    (json ? write_catalogue : print_catalogue)(catalogue);
    ng_catalogue_destroy(&catalogue);
    return NG_OK;
}
