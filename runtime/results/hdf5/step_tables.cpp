#include "runtime/results/hdf5/step_tables.h"

#include "runtime/base/assert.h"

namespace meld::record {

namespace {

constexpr StepTablePlace kWhole = {"/meld/steps", "/VTKHDF"};
constexpr StepTablePlace kPartial = {"/meld/changes", "/meld/changes", true};

}  // namespace

StepTables::StepTables(Hdf5File& file) : file_(file), whole_(file, kWhole) {}

StepTables::StepTables(Hdf5File& file, ByteReader& saved) : file_(file), whole_(file, kWhole, saved) {
    if (!saved.read<bool>()) return;
    partial_.emplace(file, kPartial, saved);
    number_ = saved.read<StepColumn>();
    for (auto left = saved.read_count(sizeof(StepColumn)); left > 0; --left) in_partial_.push_back(saved.read<StepColumn>());
}

void StepTables::save(ByteWriter& out) const {
    whole_.save(out);
    out.write(partial_.has_value());
    if (!partial_) return;
    partial_->save(out);
    out.write(number_);
    out.write_count(in_partial_.size());
    for (const StepColumn column : in_partial_) out.write(column);
}

bool StepTables::matches() const { return whole_.matches() && (!partial_ || partial_->matches()); }

void StepTables::cut() {
    whole_.cut();
    if (partial_) partial_->cut();
}

void StepTables::follow_changes() {
    MELD_CHECK(steps() == 0 && !partial_, "changes are followed from step {} on", steps());
    partial_.emplace(file_, kPartial);
    partial_->make_group("PointDataChanges");
    for (const Made& made : made_) {
        if (made.components == 0)
            partial_->make_group(made.name);
        else
            in_partial_.push_back(partial_->add_column(made.name, made.type, made.components));
    }
    made_.clear();
    number_ = partial_->add_column("StepNumber", ElementType::Int64);
}

void StepTables::make_group(const std::string& name) {
    whole_.make_group(name);
    if (partial_)
        partial_->make_group(name);
    else
        made_.push_back({.name = name});
}

StepColumn StepTables::add_column(const std::string& name, ElementType type, int components) {
    const StepColumn column = whole_.add_column(name, type, components);
    if (partial_)
        in_partial_.push_back(partial_->add_column(name, type, components));
    else
        made_.push_back({name, type, components});
    return column;
}

void StepTables::commit_changes() {
    partial_->set(number_, steps());
    partial_->commit();
}

}  // namespace meld::record
