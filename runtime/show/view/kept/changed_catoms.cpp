#include "runtime/show/view/kept/changed_catoms.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

#include "runtime/base/process/liveness.h"

namespace meld::view {

namespace {

constexpr std::uint32_t kHidden = 0xffffffff;
// So many catoms are asked about at a time: one plan for all of them, and a table that stays in the cache.
constexpr std::size_t kAskedAtOnce = 1 << 14;
// If one catom of so many has changed, a look at all facts costs less than a search from each.
constexpr std::size_t kMany = 4;

}  // namespace

// The rows of a table by their catoms.
class ChangedCatoms::Answers {
  public:
    Answers(inspect::Table table, std::size_t catom) : table_(std::move(table)), catom_(catom) {
        // By the first column rows are in order already.
        if (catom == 0) return;
        order_.resize(table_.rows());
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        std::ranges::stable_sort(order_, {}, [&](std::size_t row) { return table_.cell(row, catom_).catom; });
    }
    const inspect::Table& table() const { return table_; }

    // The first row of a catom; nothing if it has none. Cost: little for those that are asked for in the order of their numbers.
    std::optional<std::size_t> row(std::uint64_t catom) {
        if (next_ > 0 && id(next_ - 1) >= catom) next_ = 0;
        const std::size_t rows = table_.rows();
        std::size_t step = 1;
        for (; next_ + step < rows && id(next_ + step) < catom; step *= 2) next_ += step;
        // All before are less, and what is a step further is not.
        for (std::size_t end = std::min(rows, next_ + step); next_ < end;) {
            const std::size_t middle = (next_ + end) / 2;
            if (id(middle) < catom)
                next_ = middle + 1;
            else
                end = middle;
        }
        if (next_ == rows || id(next_) != catom) return std::nullopt;
        return at(next_);
    }

  private:
    std::size_t at(std::size_t i) const { return order_.empty() ? i : order_[i]; }
    std::uint64_t id(std::size_t i) const { return table_.cell(at(i), catom_).catom; }

    inspect::Table table_;
    std::size_t catom_;
    std::vector<std::size_t> order_;
    std::size_t next_ = 0;  // Of the last one that was asked for.
};

std::optional<ChangedCatoms> ChangedCatoms::make(const ModuleInfo& module, const picture::Look& look) {
    ChangedCatoms out(look);
    for (const auto& [body, question] :
         {std::pair(&look.only, &out.only_), std::pair(&look.hide, &out.hide_), std::pair(&look.colour, &out.colour_)}) {
        if (body->empty()) continue;
        *question = inspect::CatomQuestion::read(module, *body);
        if (!*question) return std::nullopt;
    }
    if (!out.colour_) return out;
    const std::vector<inspect::Table::Column> columns = out.colour_->columns();
    out.value_ = *picture::catom_values(columns);
    out.coloured_by_ = out.value_.value ? columns[*out.value_.value].name : look.colour;
    return out;
}

std::vector<std::uint64_t> ChangedCatoms::begin(sim::Subdomain& subdomain, sim::Touched& touched) {
    subdomain.refresh();
    const std::size_t count = subdomain.ensemble.index_count();
    changed_.clear();
    touched.take([&](sim::Catom catom) { changed_.push_back(catom); });
    ids_.resize(std::max({ids_.size(), count, changed_.empty() ? 0 : std::size_t{changed_.back()} + 1}), kHidden);
    std::vector<std::uint64_t> gone;
    std::size_t here = 0;
    for (const sim::Catom catom : changed_) {
        const bool owned = catom < count && subdomain.owned(catom);
        if (ids_[catom] != kHidden && (!owned || subdomain.ensemble.id(catom) != ids_[catom]))
            gone.push_back(std::exchange(ids_[catom], kHidden));
        if (owned) changed_[here++] = catom;
    }
    changed_.resize(here);
    return gone;
}

Result<ChangedCatoms::Answers> ChangedCatoms::ask(sim::Subdomain& subdomain, const inspect::CatomQuestion& question, bool all) const {
    Result<inspect::Table> table = all ? question.at_all(subdomain) : question.at(subdomain, numbers_);
    if (!table) return tl::unexpected<Error>(table.error());
    const std::size_t catom = picture::catom_values(table->columns())->catom;
    return Answers(std::move(*table), catom);
}

Result<void> ChangedCatoms::look(sim::Subdomain& subdomain, const CellBox& box, const std::function<void(const ShownCatoms&)>& shown,
                                 const std::function<void(std::uint64_t)>& hidden) {
    const bool all = changed_.size() > subdomain.ensemble.owned_count() / kMany;
    std::optional<Answers> only, hide, colour;
    const auto ask_all = [&]() -> Result<void> {
        for (const auto& [question, answers] : {std::pair(&only_, &only), std::pair(&hide_, &hide), std::pair(&colour_, &colour)}) {
            if (!*question) continue;
            Result<Answers> asked = ask(subdomain, **question, all);
            if (!asked) return tl::unexpected<Error>(asked.error());
            answers->emplace(std::move(*asked));
        }
        return {};
    };
    const auto catom_id = [&](sim::Catom catom) { return subdomain.ensemble.id(catom); };
    if (all && !changed_.empty())
        if (auto asked = ask_all(); !asked) return asked;
    ShownCatoms some;
    for (std::size_t from = 0; from < changed_.size(); from += kAskedAtOnce) {
        liveness::beat();
        const std::span<sim::Catom> block = std::span(changed_).subspan(from, std::min(kAskedAtOnce, changed_.size() - from));
        if (!std::ranges::is_sorted(block, {}, catom_id)) std::ranges::sort(block, {}, catom_id);
        if (!all) {
            numbers_.clear();
            for (const sim::Catom catom : block) numbers_.push_back(catom_id(catom));
            if (auto asked = ask_all(); !asked) return asked;
        }
        some.rows.clear();
        some.words.clear();
        for (const sim::Catom catom : block) {
            const std::uint64_t id = catom_id(catom);
            const world::Cell cell = subdomain.ensemble.cell(catom);
            const bool seen =
                (!only || only->row(id)) && (!hide || !hide->row(id)) &&
                (!look_.cut ||
                 look_.cut->keeps(static_cast<float>(subdomain.lattice.position(cell)[static_cast<std::size_t>(look_.cut->axis)])));
            if (!seen) {
                if (ids_[catom] != kHidden) hidden(std::exchange(ids_[catom], kHidden));
                continue;
            }
            ids_[catom] = static_cast<std::uint32_t>(id);
            some.rows.push_back({.id = id, .cell = box.number(cell)});
            if (colour) add_value(*colour, some);
        }
        shown(some);
    }
    // Most ticks change few.
    if (all) changed_ = std::vector<sim::Catom>();
    return {};
}

// Of the catom of the last row.
void ChangedCatoms::add_value(Answers& colour, ShownCatoms& some) const {
    ShownCatoms::Row& row = some.rows.back();
    const std::optional<std::size_t> said = colour.row(row.id);
    if (!said) return;
    row.has_value = true;
    using Kind = picture::CatomValues::Kind;
    if (value_.kind == Kind::Whole || value_.kind == Kind::Real) {
        const Value v = colour.table().cell(*said, *value_.value);
        row.value = value_.kind == Kind::Whole ? static_cast<std::uint64_t>(v.integer) : std::bit_cast<std::uint64_t>(v.real);
        return;
    }
    std::string word = value_.value ? colour.table().text(*said, *value_.value) : picture::kHolds;
    if (some.words.empty() || some.words.back() != word) some.words.push_back(std::move(word));
    row.value = some.words.size() - 1;
}

}  // namespace meld::view
