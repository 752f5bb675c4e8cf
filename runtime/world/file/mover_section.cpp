#include "runtime/world/file/mover_section.h"

#include "runtime/world/file/motion_keys.h"

namespace meld::world {
namespace {

void read_swing(TomlReader& reader, const Section& section, const toml::table& table, SwingOptions& swing) {
    swing.place = reader.place(table.source());
    section.read("swing", swing.swing);
    section.read("tilt", swing.tilt);
    section.read_positive("frequency", swing.frequency);
    section.read_number("phase", swing.phase);
    for (const char* key : {"frequency", "phase"})
        if (section.has(key) && swing.swing == Vec3{} && swing.tilt == Vec3{})
            section.wrong(key, "nothing swings here", "write swing = [0, 0, 0.1], or tilt = [10, 0, 0]");
}

void read_mover(TomlReader& reader, const toml::table& table, MoverOptions& mover) {
    const Section section(reader, table, "[[motion.mover]]", {"where", "swing", "tilt", "frequency", "phase", "spin", "pivot"});
    if (auto where = section.read_region("where")) mover.where = *where;
    if (!section.has("where")) section.wrong("where", "a [[motion.mover]] moves no catoms", "write where = \"id == 0\"");
    read_prescribed(reader, section, table, mover);
    if (!mover.moves()) reader.wrong(table.source(), "this [[motion.mover]] moves nothing", "write swing = [0, 0, 0.1], tilt or spin");
}

void read_gravity_swing(TomlReader& reader, const toml::node& node, SwingOptions& swing) {
    if (!node.is_table())
        return reader.wrong(node.source(), "[motion] gravity_swing " + type_mismatch(node, "a table [motion.gravity_swing]"));
    const toml::table& table = *node.as_table();
    const Section section(reader, table, "[motion.gravity_swing]", {"swing", "tilt", "frequency", "phase"});
    read_swing(reader, section, table, swing);
    if (swing.swing == Vec3{} && swing.tilt == Vec3{})
        reader.wrong(table.source(), "this [motion.gravity_swing] does nothing", "write swing = [1, 0, 0], or tilt = [10, 0, 0]");
}

}  // namespace

void read_prescribed(TomlReader& reader, const Section& section, const toml::table& table, PrescribedOptions& motion) {
    read_swing(reader, section, table, motion.swing);
    section.read("spin", motion.spin);
    Vec3 pivot{};
    if (section.has("pivot")) section.read("pivot", pivot), motion.pivot = pivot;
    if (motion.pivot && !motion.turns()) section.wrong("pivot", "nothing turns about this pivot", "write spin or tilt, too");
}

void read_movers(TomlReader& reader, const toml::table& motion, PhysicsOptions& p) {
    each_table(reader, motion, "motion", "mover", [&](const toml::table& t) { read_mover(reader, t, p.movers.emplace_back()); });
    if (const toml::node* node = motion.get("gravity_swing")) read_gravity_swing(reader, *node, p.gravity_swing.emplace());
}

}  // namespace meld::world
