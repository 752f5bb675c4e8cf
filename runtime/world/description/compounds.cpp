#include "runtime/world/description/compounds.h"

#include <algorithm>
#include <numbers>
#include <utility>

namespace meld::world {

namespace {

physics::Vec3 scaled(double factor, const Vec3& v) { return {factor * v[0], factor * v[1], factor * v[2]}; }

}  // namespace

physics::PlacedCompound placed_compound(const CompoundForm& compound, double diameter, std::size_t place) {
    std::vector<physics::ShapePart> parts;
    for (const CompoundPart& part : compound.parts) {
        const BodyForm::Core core = part.form.core(part.diameter / 2);
        physics::ShapePart& made = parts.emplace_back();
        made.core_m = scaled(diameter, core.half), made.rounding_m = diameter * core.rounding;
        made.at_m = scaled(diameter, part.at);
        if (part.turned != Vec3{}) made.turn = physics::turned_by({}, scaled(std::numbers::pi / 180, part.turned));
        made.share = part.share.value_or(physics::solid_of(made).volume_m3());
    }
    physics::PlacedCompound made = physics::compound_of(std::move(parts));
    made.shape.name = static_cast<std::uint32_t>(place);
    return made;
}

physics::BodyShape shape_of(const CompoundForm& compound, double diameter, std::size_t place) {
    return placed_compound(compound, diameter, place).shape;
}

std::vector<physics::BodyShape> compounds_of(const PhysicsOptions& options, double diameter) {
    std::vector<physics::BodyShape> shapes;
    for (std::size_t place = 0; place < options.compounds.size(); ++place)
        shapes.push_back(shape_of(options.compounds[place], diameter, place));
    return shapes;
}

RoundedBody look_of(const physics::BodyShape& shape, const physics::Quat& turn, double diameter_m) {
    const std::array<double, 4> turned{turn.w, turn.x, turn.y, turn.z};
    if (shape.is_compound()) return RoundedBody::of_compound(shape.name, shape.radius_m() / diameter_m, turned);
    const physics::Vec3 core = shape.core_m;
    return {{core.x / diameter_m, core.y / diameter_m, core.z / diameter_m}, shape.rounding_m / diameter_m, turned};
}

}  // namespace meld::world
