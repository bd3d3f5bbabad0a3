#include "imgui_internal.h"

#include "app/input.h"
#include "editor/layout.h"

#include <imgui.h>

#include <cstring>

// The windows of this frame and the one before, in the order in which they appeared.
namespace
{
struct window {
    char title[64];
    bool shown; // in this frame
};
constexpr uint32_t most_windows = 16;
window windows[most_windows];
ng_panel panels[most_windows];
uint32_t window_count, window_at; // that is being filled; most_windows: one too many

// Those that the last frame did not show make room.
void place_windows(float width, float height)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < window_count; i++) {
        if (!windows[i].shown)
            continue;
        windows[kept] = windows[i];
        windows[kept].shown = false;
        panels[kept++] = panels[i];
    }
    window_count = kept;
    ng_layout_panels(width, height, panels, window_count);
}

// Where it is in the list; a new one wants nothing yet: Dear ImGui measures it in its first frame, hidden.
uint32_t find_window(const char *title)
{
    uint32_t i = 0;
    while (i < window_count && strncmp(windows[i].title, title, sizeof windows[i].title - 1) != 0)
        i++;
    if (i == window_count && i < most_windows) {
        windows[i] = {};
        strncpy(windows[i].title, title, sizeof windows[i].title - 1);
        panels[i] = {};
        window_count++;
    }
    return i;
}
} // namespace

void ng_imgui_create(float scale)
{
    ImGui::CreateContext();
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr; // leave no file behind
    io.FontGlobalScale = scale;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().ScaleAllSizes(scale);
}

void ng_imgui_destroy(void)
{
    ImGui::DestroyContext();
    window_count = 0;
}

const unsigned char *ng_imgui_font(uint32_t *width, uint32_t *height)
{
    unsigned char *pixels;
    int w, h;
    ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &w, &h);
    *width = static_cast<uint32_t>(w);
    *height = static_cast<uint32_t>(h);
    return pixels;
}

void ng_imgui_begin(float width, float height, float seconds, const struct ng_input *input)
{
    ImGuiIO &io = ImGui::GetIO();
    io.DisplaySize = ImVec2(width, height);
    io.DeltaTime = seconds > 0 ? seconds : 1e-4f;
    if (input) {
        io.MousePos = ImVec2(input->pointer[0], input->pointer[1]);
        io.MouseWheel = input->scroll;
        for (int i = 0; i < NG_BUTTON_COUNT; i++)
            io.MouseDown[i] = input->buttons[i] || input->clicked[i]; // also if it is up again by now
    }
    place_windows(width, height);
    ImGui::NewFrame();
}

bool ng_imgui_has_pointer(void)
{
    return ImGui::GetIO().WantCaptureMouse;
}

bool ng_imgui_window_begin(const char *title)
{
    ImGuiWindowFlags flags =
        ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings;
    window_at = find_window(title);
    if (window_at < most_windows) {
        const ng_panel &p = panels[window_at];
        ImGui::SetNextWindowPos(ImVec2(p.at[0], p.at[1]));
        ImGui::SetNextWindowSize(ImVec2(p.size[0], p.size[1]));
        // Said here, since Dear ImGui would find out a frame late.
        flags |= p.size[0] < p.wanted[0] ? ImGuiWindowFlags_HorizontalScrollbar : 0;
        flags |= p.size[0] < p.wanted[0] || p.size[1] < p.wanted[1] ? 0 : ImGuiWindowFlags_NoScrollbar;
    }
    bool open = ImGui::Begin(title, nullptr, flags);
    ImGui::BeginGroup();
    return open;
}

// What it would take to show all of it.
static void measure_window(void)
{
    ImGui::EndGroup();
    const ImGuiStyle &style = ImGui::GetStyle();
    const ImVec2 content = ImGui::GetItemRectSize(), edge = style.WindowPadding;
    const float title = ImGui::GetFontSize() + 2 * style.FramePadding.y;
    const float name = ImGui::CalcTextSize(windows[window_at].title).x + 3 * ImGui::GetFontSize();
    ng_panel &p = panels[window_at];
    p.wanted[1] = title;
    if (ImGui::IsWindowCollapsed()) // as wide as before
        return;
    p.wanted[0] = content.x + 2 * edge.x > name ? content.x + 2 * edge.x : name;
    p.wanted[1] += content.y + 2 * edge.y;
    p.wanted[0] += p.size[1] > 0 && p.size[1] < p.wanted[1] ? style.ScrollbarSize : 0;
}

void ng_imgui_window_end(void)
{
    if (window_at < most_windows) {
        measure_window();
        windows[window_at].shown = true;
    } else {
        ImGui::EndGroup();
    }
    ImGui::End();
}

void ng_imgui_text(const char *fmt, va_list args)
{
    ImGui::TextV(fmt, args);
}

void ng_imgui_same_line(void)
{
    ImGui::SameLine();
}

bool ng_imgui_choice(const char *group, const char *word, bool chosen)
{
    ImGui::PushID(group);
    bool now = ImGui::RadioButton(word, chosen);
    ImGui::PopID();
    return now;
}

bool ng_imgui_slider(const char *name, float *value, float from, float to, const char *format)
{
    return ImGui::SliderFloat(name, value, from, to, format);
}

bool ng_imgui_button(const char *word)
{
    return ImGui::Button(word);
}

float ng_imgui_caption(float x, float y, const char *text)
{
    const float margin = 3;
    const ImVec2 picture = ImGui::GetIO().DisplaySize;
    const float edge = (x < 0 ? -x : x) + margin, wide = picture.x - 2 * edge;
    const float wrap = wide > ImGui::GetFontSize() ? wide : ImGui::GetFontSize();
    const ImVec2 letters = ImGui::CalcTextSize(text, nullptr, false, wrap);
    ImVec2 size(letters.x + 2 * margin, letters.y + 2 * margin);
    ImVec2 from(x < 0 ? picture.x + x - size.x : x, y < 0 ? picture.y + y - size.y : y);
    ImDrawList *list = ImGui::GetForegroundDrawList();
    list->AddRectFilled(from, ImVec2(from.x + size.x, from.y + size.y), IM_COL32(0, 0, 0, 170));
    list->AddText(nullptr, 0, ImVec2(from.x + margin, from.y + margin), IM_COL32_WHITE, text, nullptr, wrap);
    return size.y;
}

struct ng_imgui_counts ng_imgui_end(void)
{
    ImGui::Render();
    const ImDrawData *data = ImGui::GetDrawData();
    uint32_t draws = 0;
    for (int i = 0; i < data->CmdListsCount; i++)
        draws += static_cast<uint32_t>(data->CmdLists[i]->CmdBuffer.Size);
    return {static_cast<uint32_t>(data->TotalVtxCount), static_cast<uint32_t>(data->TotalIdxCount), draws};
}

void ng_imgui_copy(struct ng_imgui_vertex *vertices, uint32_t *indices, struct ng_imgui_draw *draws)
{
    const ImDrawData *data = ImGui::GetDrawData();
    uint32_t vertex_base = 0, index_base = 0;
    for (int i = 0; i < data->CmdListsCount; i++) {
        const ImDrawList *list = data->CmdLists[i];
        for (const ImDrawVert &v : list->VtxBuffer)
            *vertices++ = {{v.pos.x, v.pos.y}, {v.uv.x, v.uv.y}, v.col};
        for (const ImDrawCmd &c : list->CmdBuffer) {
            for (uint32_t k = 0; k < c.ElemCount; k++)
                indices[index_base + c.IdxOffset + k] =
                    vertex_base + c.VtxOffset + list->IdxBuffer[static_cast<int>(c.IdxOffset + k)];
            *draws++ = {index_base + c.IdxOffset,
                        c.ElemCount,
                        {c.ClipRect.x, c.ClipRect.y},
                        {c.ClipRect.z, c.ClipRect.w}};
        }
        vertex_base += static_cast<uint32_t>(list->VtxBuffer.Size);
        index_base += static_cast<uint32_t>(list->IdxBuffer.Size);
    }
}
