#include "imgui_internal.h"

#include "app/input.h"

#include <imgui.h>

#include <cfloat>

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
    ImGui::NewFrame();
}

bool ng_imgui_has_pointer(void)
{
    return ImGui::GetIO().WantCaptureMouse;
}

bool ng_imgui_window_begin(const char *title, float x, float y)
{
    const float most = ImGui::GetIO().DisplaySize.y - y;
    ImGui::SetNextWindowPos(ImVec2(x, y), ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(FLT_MAX, most > 0 ? most : FLT_MAX));
    return ImGui::Begin(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize);
}

void ng_imgui_window_end(void)
{
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

void ng_imgui_caption(float x, float y, const char *text)
{
    const float margin = 3;
    ImVec2 picture = ImGui::GetIO().DisplaySize, letters = ImGui::CalcTextSize(text);
    ImVec2 size(letters.x + 2 * margin, letters.y + 2 * margin);
    ImVec2 from(x < 0 ? picture.x + x - size.x : x, y < 0 ? picture.y + y - size.y : y);
    ImDrawList *list = ImGui::GetForegroundDrawList();
    list->AddRectFilled(from, ImVec2(from.x + size.x, from.y + size.y), IM_COL32(0, 0, 0, 170));
    list->AddText(ImVec2(from.x + margin, from.y + margin), IM_COL32_WHITE, text);
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
