// Reading lists of modules. Rows of Catoms2D lie along z, each odd one shifted by half a module; the other lattices number
// cells as ours do.
#include "runtime/world/model/visiblesim.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <initializer_list>
#include <map>
#include <optional>
#include <utility>

#include "runtime/module/abi/port_numbers.h"

namespace meld::model {
namespace {

using tinyxml2::XMLElement;
using Int3 = std::array<std::int64_t, 3>;

constexpr std::size_t kMaxCells = 10'000'000;
constexpr std::int64_t kMaxGridPosition = 1 << 20;

// "1,2,3" or "1,2"; positions may be written "1.0".
std::optional<Int3> numbers(std::string_view text) {
    Int3 out{};
    for (std::size_t i = 0;; ++i) {
        const std::size_t end = std::min(text.find(','), text.size());
        std::string_view field = text.substr(0, end);
        while (field.starts_with(' ')) field.remove_prefix(1);
        while (field.ends_with(' ')) field.remove_suffix(1);
        double value = 0;
        const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (i == 3 || error != std::errc() || stop != field.data() + field.size() ||
            !(value > -kMaxGridPosition && value < kMaxGridPosition))
            return std::nullopt;
        out[i] = static_cast<std::int64_t>(value);
        if (static_cast<double>(out[i]) != value) return std::nullopt;
        if (end == text.size()) return i == 0 ? std::nullopt : std::optional(out);
        text.remove_prefix(end + 1);
    }
}

// What a world has no place for, as it is reported; everything else by its name in the configuration.
constexpr std::pair<std::string_view, std::string_view> kElements[] = {
    {"obstacleList", "obstacles"}, {"camera", "the camera"}, {"spotlight", "the light"}};
constexpr std::pair<std::string_view, std::string_view> kAttributes[] = {
    {"color", "colours"}, {"orientation", "orientations"}, {"id", "numbers of modules"}};

template <std::size_t N>
std::string in_words(std::string_view name, const std::pair<std::string_view, std::string_view> (&words)[N], const char* otherwise) {
    const auto* const found = std::ranges::find(words, name, &std::pair<std::string_view, std::string_view>::first);
    return found == std::end(words) ? fmt::format(fmt::runtime(otherwise), name) : std::string(found->second);
}

// The ports of VisibleSim's modules on each lattice.
std::string_view ports_on(std::string_view lattice) {
    std::string_view last = kLatticePorts;
    // Of two robots on one lattice the later is VisibleSim's.
    for (const PortNumbers& robot : robot_port_numbers())
        if (robot.lattice == lattice) last = robot.name;
    return last;
}

class Import {
  public:
    Import(const std::string& path, std::string_view lattice) : path_(path), lattice_(lattice) {}

    Result<void> read(const XMLElement& world) {
        const XMLElement* list = world.FirstChildElement("blockList");
        if (!list) return wrong(world, "there is no blockList in it", "");
        if (const char* grid = world.Attribute("gridSize") ? world.Attribute("gridSize") : world.Attribute("gridsize")) {
            const auto size = numbers(grid);
            if (!size) return wrong(world, fmt::format("gridSize = \"{}\" is not a size", grid), "write gridSize = \"10,10,10\"");
            grid_ = size;
        }
        leave_out_attributes(world, {"gridSize", "gridsize"});
        leave_out_attributes(*list, {});
        for (const XMLElement* e = list->FirstChildElement(); e; e = e->NextSiblingElement())
            if (auto done = read_entry(*e); !done) return done;
        if (cells_.empty()) return wrong(*list, "its blockList lists no blocks", "");
        bool target = false;
        for (const XMLElement* e = world.FirstChildElement(); e; e = e->NextSiblingElement()) {
            const std::string_view name = e->Name();
            if (e == list) continue;
            if (name != "targetGrid" && name != "targetList") {
                leave_out_element(name);
                continue;
            }
            for (const XMLElement* one = name == "targetGrid" ? e : e->FirstChildElement(); one;
                 one = name == "targetGrid" ? nullptr : one->NextSiblingElement()) {
                if (target)
                    leave_out("targets after the first");
                else if (auto done = read_target(*one); !done)
                    return done;
                target = true;
            }
        }
        return {};
    }

    // What stands beside the world in the root of a newer configuration.
    void leave_out_beside(const XMLElement& root, const XMLElement& world) {
        for (const XMLElement* e = root.FirstChildElement(); e; e = e->NextSiblingElement())
            if (e != &world) leave_out_element(e->Name());
    }

    ImportedWorld world() && {
        ImportedWorld out;
        out.cells = cells_.size();
        out.target_cells = target_.size();
        if (outside_ > 0) left_out_.push_back(fmt::format("{} cells of the target outside of the grid", outside_));
        out.left_out = std::move(left_out_);
        // A comment ends with its line.
        std::string name = path_;
        std::ranges::replace_if(name, [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 0x7f; }, '?');
        out.text = fmt::format("# The modules of {}, a configuration of VisibleSim.\nlattice = \"{}\"\nports = \"{}\"\n\n[[body]]\n", name,
                               lattice_, ports_on(lattice_));
        out.text += listed(cells_);
        if (!target_.empty()) out.text += "\n[target]\n" + listed(target_);
        if (marked_.empty()) return out;
        out.text += "\n# Modules that it marks; a program that declares such a predicate can be given it.\n# [facts]\n";
        for (const auto& [mark, regions] : marked_) {
            out.text += fmt::format("# {} = [", mark);
            for (const std::string& region : regions) out.text += fmt::format("{}\"{}\"", &region == &regions.front() ? "" : ", ", region);
            out.text += "]\n";
        }
        return out;
    }

  private:
    using Places = std::map<Int3, int>;  // The line of each cell.

    static std::string listed(const std::vector<Int3>& cells) {
        std::string text = "cells = [\n";
        for (const Int3& cell : cells) text += fmt::format("    [{}, {}, {}],\n", cell[0], cell[1], cell[2]);
        return text + "]\n";
    }

    tl::unexpected<Error> wrong(const XMLElement& element, const std::string& problem, std::string suggestion) const {
        return fail(fmt::format("{}:{}: {}", path_, element.GetLineNum(), problem), std::move(suggestion));
    }

    void leave_out(std::string what) {
        if (std::ranges::find(left_out_, what) == left_out_.end()) left_out_.push_back(std::move(what));
    }
    void leave_out_element(std::string_view name) { leave_out(in_words(name, kElements, "<{}>")); }
    void leave_out_attributes(const XMLElement& element, std::initializer_list<std::string_view> known) {
        for (const tinyxml2::XMLAttribute* a = element.FirstAttribute(); a; a = a->Next())
            if (std::ranges::find(known, std::string_view(a->Name())) == known.end()) leave_out(in_words(a->Name(), kAttributes, "{}"));
    }

    Result<void> read_entry(const XMLElement& entry) {
        const std::string_view name = entry.Name();
        if (name == "block") {
            leave_out_attributes(entry, {"position"});
            const Result<Int3> at = read_position(entry, "a block");
            if (!at) return tl::unexpected<Error>(at.error());
            if (auto added = add(entry, *at); !added) return added;
            // They become facts only if a program has such predicates.
            for (const char* mark : {"leader", "master"})
                if (entry.BoolAttribute(mark)) {
                    const Int3& cell = cells_.back();
                    marked_[mark].push_back(fmt::format("cell == ({}, {}, {})", cell[0], cell[1], cell[2]));
                }
            return {};
        }
        if (name == "blocksLine") {
            leave_out_attributes(entry, {"line", "plane", "values"});
            return read_line(entry, [&](Int3 at) { return add(entry, at); });
        }
        if (name == "blockBox") {
            leave_out_attributes(entry, {"boxOrigin", "boxSize"});
            return read_box(entry);
        }
        if (name == "csg" || name == "mesh")
            return wrong(entry, fmt::format("modules that VisibleSim computes from a {} are not imported", name),
                         name == "mesh" ? "name the model in a world: shape = \"mesh('part.obj', size = 50)\""
                                        : "describe it as the shape of a world");
        leave_out_element(name);
        return {};
    }

    // Cells and lines of cells: <targetGrid>, or <target format="grid">.
    Result<void> read_target(const XMLElement& target) {
        const char* const format = target.Attribute("format");
        if (format != nullptr && std::string_view(format) != "grid") {
            leave_out(fmt::format("a target of the format {}", format));
            return {};
        }
        leave_out_attributes(target, {"format"});
        plane_ = 0;
        for (const XMLElement* e = target.FirstChildElement(); e; e = e->NextSiblingElement()) {
            const std::string_view name = e->Name();
            if (name == "cell" || name == "block") {
                leave_out_attributes(*e, {"position"});
                const Result<Int3> at = read_position(*e, "a cell");
                if (!at) return tl::unexpected<Error>(at.error());
                if (auto done = add_target(*e, *at); !done) return done;
            } else if (name == "targetLine" || name == "blocksLine") {
                leave_out_attributes(*e, {"line", "plane", "values"});
                if (auto done = read_line(*e, [&](Int3 at) { return add_target(*e, at); }); !done) return done;
            } else {
                leave_out_element(name);
            }
        }
        return {};
    }

    Result<Int3> read_position(const XMLElement& entry, const char* what) const {
        const char* text = entry.Attribute("position");
        const auto at = text ? numbers(text) : std::nullopt;
        if (!at)
            return wrong(entry, fmt::format("position = \"{}\" of {} is not a cell", text ? text : "", what), "write position = \"1,2,3\"");
        // A flat world may list x and y only, whichever axis its rows lie along.
        const bool short_row = lattice_ == "hex" && std::string_view(text).find(',') == std::string_view(text).rfind(',');
        return short_row ? Int3{(*at)[0], 0, (*at)[1]} : *at;
    }

    template <class Add>
    Result<void> read_line(const XMLElement& entry, const Add& add_cell) {
        const char* values = entry.Attribute("values");
        if (!values) return wrong(entry, fmt::format("a {} has no values", entry.Name()), "write values = \"0110\"");
        // The plane stays that of the line before.
        plane_ = entry.IntAttribute("plane", plane_);
        const std::string_view row = values;
        for (std::size_t i = 0; i < row.size(); ++i)
            if (row[i] == '1')
                if (auto done = add_cell({static_cast<std::int64_t>(i), entry.IntAttribute("line", 0), plane_}); !done) return done;
        return {};
    }

    // As VisibleSim does, without the last row of the grid on each axis.
    Result<void> read_box(const XMLElement& entry) {
        if (!grid_) return wrong(entry, "a blockBox needs the world's gridSize", "write <world gridSize=\"10,10,10\">");
        Int3 first{}, end{};
        for (std::size_t i = 0; i < 3; ++i) end[i] = (*grid_)[i] - 1;
        if (const char* text = entry.Attribute("boxOrigin")) {
            const auto origin = numbers(text);
            if (!origin) return wrong(entry, fmt::format("boxOrigin = \"{}\" is not a cell", text), "");
            for (std::size_t i = 0; i < 3; ++i) first[i] = std::max<std::int64_t>(0, (*origin)[i]);
        }
        if (const char* text = entry.Attribute("boxSize")) {
            const auto size = numbers(text);
            if (!size) return wrong(entry, fmt::format("boxSize = \"{}\" is not a size", text), "");
            for (std::size_t i = 0; i < 3; ++i) end[i] = std::min(end[i], first[i] + (*size)[i]);
        }
        for (std::int64_t z = first[2]; z < end[2]; ++z)
            for (std::int64_t y = first[1]; y < end[1]; ++y)
                for (std::int64_t x = first[0]; x < end[0]; ++x)
                    if (auto done = add(entry, {x, y, z}); !done) return done;
        return {};
    }

    bool in_grid(const Int3& at) const {
        if (!grid_) return true;
        for (std::size_t i = 0; i < 3; ++i)
            // A grid of two numbers does not limit the third.
            if (at[i] < 0 || ((*grid_)[i] > 0 && at[i] >= (*grid_)[i])) return false;
        return true;
    }

    Result<void> add(const XMLElement& entry, Int3 at) {
        if (cells_.size() == kMaxCells)
            return wrong(entry, fmt::format("there are more than {} million modules", kMaxCells / 1'000'000), "");
        if (!in_grid(at))
            return wrong(entry,
                         fmt::format("a module at {},{},{} lies outside of gridSize = \"{},{},{}\"", at[0], at[1], at[2], (*grid_)[0],
                                     (*grid_)[1], (*grid_)[2]),
                         "make gridSize larger, or take it out");
        const Result<Int3> cell = cell_of(entry, at, "a module");
        if (!cell) return tl::unexpected<Error>(cell.error());
        const auto [before, added] = module_at_.emplace(*cell, entry.GetLineNum());
        if (!added)
            return wrong(entry, fmt::format("a module at {},{},{} stands where that of line {} is", at[0], at[1], at[2], before->second),
                         "take one of the two out");
        cells_.push_back(*cell);
        return {};
    }

    Result<void> add_target(const XMLElement& entry, Int3 at) {
        if (!in_grid(at)) {
            ++outside_;
            return {};
        }
        const Result<Int3> cell = cell_of(entry, at, "a cell of the target");
        if (!cell) return tl::unexpected<Error>(cell.error());
        // A cell that is listed twice is one.
        if (target_at_.emplace(*cell, entry.GetLineNum()).second) target_.push_back(*cell);
        return {};
    }

    Result<Int3> cell_of(const XMLElement& entry, Int3 at, const char* what) const {
        const bool flat = lattice_ == "square" || lattice_ == "hex";
        if (lattice_ == "hex") {
            // Rows are shifted to and fro; ours are shifted ever further.
            const std::int64_t odd = at[2] & 1;
            std::swap(at[1], at[2]);
            at[0] -= (at[1] - odd) / 2;
        }
        if (flat && at[2] != 0)
            return wrong(entry, fmt::format("{} is not in the plane of the {} lattice", what, lattice_),
                         "import it with another --lattice");
        if (std::ranges::any_of(at, [](std::int64_t x) { return x < -kMaxGridPosition || x >= kMaxGridPosition; }))
            return wrong(entry,
                         fmt::format("{} is too far out: coordinates lie between {} and {}", what, -kMaxGridPosition, kMaxGridPosition - 1),
                         "");
        return at;
    }

    const std::string& path_;
    std::string_view lattice_;
    std::optional<Int3> grid_;
    int plane_ = 0;
    std::vector<Int3> cells_, target_;
    Places module_at_, target_at_;
    std::size_t outside_ = 0;
    std::map<std::string, std::vector<std::string>> marked_;
    std::vector<std::string> left_out_;
};

// XML begins with its declaration; configurations are found with a comment before it, which says what they are. It says nothing that
// matters here, so it becomes blanks, and all lines keep their numbers.
std::string without_declaration(std::string_view xml) {
    std::string out(xml);
    std::size_t at = 0;
    for (;;) {
        at = std::min(out.find_first_not_of(" \t\r\n", at), out.size());
        if (out.compare(at, 4, "<!--") != 0) break;
        const std::size_t end = out.find("-->", at);
        if (end == std::string::npos) return out;
        at = end + 3;
    }
    const std::size_t end = out.find("?>", at);
    if (at == 0 || out.compare(at, 5, "<?xml") != 0 || end == std::string::npos) return out;
    std::replace_if(
        out.begin() + static_cast<std::ptrdiff_t>(at), out.begin() + static_cast<std::ptrdiff_t>(end + 2), [](char c) { return c != '\n'; },
        ' ');
    return out;
}

}  // namespace

Result<ImportedWorld> import_visiblesim(std::string_view xml, const std::string& path, std::string_view lattice) {
    tinyxml2::XMLDocument document;
    const std::string text = without_declaration(xml);
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
        return fail(fmt::format("{}:{}: this is not XML ({})", path, std::max(1, document.ErrorLineNum()), document.ErrorName()));
    // Newer configurations have a root around the world.
    const XMLElement* root = document.RootElement();
    const XMLElement* world = root && std::string_view(root->Name()) != "world" ? root->FirstChildElement("world") : root;
    if (!world) return fail(fmt::format("{} is not a configuration of VisibleSim: there is no world in it", path));
    Import import(path, lattice);
    if (auto done = import.read(*world); !done) return tl::unexpected(done.error());
    if (world != root) import.leave_out_beside(*root, *world);
    return std::move(import).world();
}

}  // namespace meld::model
