#include "runtime/world/file/form_section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/description/compounds.h"
#include "runtime/world/file/motion_keys.h"

namespace meld::world {

namespace {

constexpr std::string_view kFormKeys[] = {"shape", "edges", "length", "height", "rounding"};
constexpr std::string_view kSolids[] = {"sphere", "cube", "box", "cylinder", "capsule"};
// Of each coordinate, in diameters; and of more turns, too few digits are left to say how something stands.
constexpr double kFarthestPart = 1e6, kMostDegreesOfPart = 1e6;

// Either a solid or a compound, which has no other keys.
void read_kind(const Section& section, std::span<const CompoundForm> compounds, BodyForm& form) {
    std::string name = form.kind;
    section.read("shape", name);
    const auto known = std::ranges::find(compounds, name, &CompoundForm::name);
    if (known != compounds.end()) {
        form.kind = name, form.compound = static_cast<std::size_t>(known - compounds.begin());
        for (const std::string_view key : kFormKeys)
            if (key != "shape" && section.has(key))
                section.wrong(key, fmt::format("{} has no effect on the compound {}", key, name), "write it into one of its parts");
        return;
    }
    if (std::ranges::find(kSolids, name) == std::end(kSolids)) {
        std::vector<std::string_view> choices(std::begin(kSolids), std::end(kSolids));
        for (const CompoundForm& compound : compounds) choices.push_back(compound.name);
        return section.wrong("shape", fmt::format("shape = \"{}\" does not exist", name), did_you_mean(name, choices));
    }
    form.kind = name;
}

void read_solid(const Section& section, BodyForm& form) {
    refuse_keys_of_others(section, form.kind,
                          {{"sphere", {}},
                           {"cube", {"rounding"}},
                           {"box", {"edges", "rounding"}},
                           {"cylinder", {"height", "rounding"}},
                           {"capsule", {"length"}}});
    if (form.kind == "box" && !section.has("edges"))
        section.wrong("shape", "a box has no edges", "write edges = [2, 1, 1], in catom diameters");
    section.read("edges", form.edges);
    if (std::ranges::any_of(form.edges, [](double edge) { return !(edge > 0); }))
        section.wrong("edges", "an edge of a box is not positive", "write edges = [2, 1, 1], in catom diameters");
    section.read_positive("length", form.length);
    if (form.kind == "cylinder") {
        form.length = 1;
        section.read_positive("height", form.length);
    }
    if (section.has("rounding")) {
        double value = 0;
        section.read_number("rounding", value, 0);
        form.rounding = value;
        const double least = form.kind == "box" ? std::ranges::min(form.edges) : form.kind == "cylinder" ? std::min(form.length, 1.0) : 1.0;
        if (!(2 * value < least))
            section.wrong("rounding", fmt::format("edges rounded by {} leave nothing of the {}", value, form.kind),
                          fmt::format("write less than half of its least edge, {}", least / 2));
    }
}

void read_part(TomlReader& reader, const toml::table& table, CompoundPart& part) {
    const Section section(reader, table, "[[motion.compound.part]]",
                          {"shape", "edges", "length", "height", "rounding", "diameter", "at", "turned", "share"});
    if (const auto form = read_form(section, {})) part.form = *form;
    if (part.form.kind == "box" && section.has("diameter"))
        section.wrong("diameter", "a box has edges and no diameter", "take diameter out");
    section.read_positive("diameter", part.diameter);
    section.read("at", part.at);
    if (std::ranges::any_of(part.at, [](double x) { return !(std::abs(x) <= kFarthestPart); }))
        section.wrong("at", "a part of a compound is more than a million diameters away", "write at = [1, 0, 0], in catom diameters");
    section.read("turned", part.turned);
    if (!(std::hypot(part.turned[0], part.turned[1], part.turned[2]) <= kMostDegreesOfPart))
        section.wrong("turned", "a part is turned by more than a million degrees", "write turned = [0, 0, 90]: about z, by 90 degrees");
    double share = 1;
    if (section.has("share")) section.read_positive("share", share), part.share = share;
}

void read_compound(TomlReader& reader, const toml::table& table, std::span<const CompoundForm> before, CompoundForm& compound) {
    const Section section(reader, table, "[[motion.compound]]", {"name", "part"});
    compound.place = reader.place(table.source());
    section.read("name", compound.name);
    if (compound.name.empty()) section.wrong("name", "a [[motion.compound]] has no name", "write name = \"dumbbell\"");
    if (std::ranges::find(kSolids, compound.name) != std::end(kSolids))
        section.wrong("name", fmt::format("{} is the name of a solid", compound.name), "give the compound another name");
    if (std::ranges::find(before, compound.name, &CompoundForm::name) != before.end())
        section.wrong("name", fmt::format("there are two compounds {}", compound.name), "give one of them another name");
    each_table(reader, table, "motion.compound", "part",
               [&](const toml::table& part) { read_part(reader, part, compound.parts.emplace_back()); });
    if (compound.parts.empty())
        return section.wrong("part", fmt::format("the compound {} has no parts", compound.name),
                             "write tables [[motion.compound.part]] behind it");
    const auto shares = std::ranges::count_if(compound.parts, [](const CompoundPart& part) { return part.share.has_value(); });
    if (shares != 0 && static_cast<std::size_t>(shares) != compound.parts.size())
        return section.wrong("part",
                             fmt::format("some parts of the compound {} have a share of its mass, and others have none", compound.name),
                             "give each of them a share, or none: then their volumes count");
    if (reader.error()) return;
    if (const auto fine = physics::check(shape_of(compound, 1, 0)); !fine)
        reader.wrong(Error{fmt::format("{}: the compound {} cannot be: {}", compound.place, compound.name, fine.error().problem),
                           fine.error().suggestion});
}

}  // namespace

std::optional<BodyForm> read_form(const Section& section, std::span<const CompoundForm> compounds) {
    if (!section.has("shape")) {
        for (const std::string_view key : kFormKeys)
            if (section.has(key)) section.wrong(key, fmt::format("{} is of a shape, and none is given", key), "write shape = \"box\" too");
        return std::nullopt;
    }
    BodyForm form;
    read_kind(section, compounds, form);
    if (!form.compound) read_solid(section, form);
    if (!form.is_sphere() && section.has("inertia"))
        section.wrong("inertia", fmt::format("the inertia of a {} follows from its shape", form.kind), "take inertia out");
    return form;
}

void read_compounds(TomlReader& reader, const toml::table& motion, std::vector<CompoundForm>& compounds) {
    each_table(reader, motion, "motion", "compound", [&](const toml::table& table) {
        CompoundForm compound;
        read_compound(reader, table, compounds, compound);
        compounds.push_back(std::move(compound));
    });
}

std::optional<double> thickness_of(const BodyForm& form, std::span<const CompoundForm> compounds) {
    if (form.compound) return 2 * shape_of(compounds[*form.compound], 1, 0).least_m();
    if (form.kind == "box") return std::ranges::min(form.edges);
    return std::nullopt;
}

}  // namespace meld::world
