#include "runtime/results/facts/facts_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <queue>
#include <string_view>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/process/liveness.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/facts/facts_csv.h"
#include "runtime/results/facts/facts_hdf5.h"
#include "runtime/results/facts/sorted_facts.h"

namespace meld::record {

namespace {

// Names that people give to data of other formats.
constexpr std::array<std::string_view, 5> kOtherFormats = {".parquet", ".arrow", ".feather", ".tsv", ".json"};

// A fact a line, as a program could write it.
class TextFactsFile : public FactsFile {
  public:
    explicit TextFactsFile(OutputFile file) : file_(std::move(file)) {}
    void begin(const FactTable&) override {}
    void rows(std::span<const std::byte> packed) override { file_.write({reinterpret_cast<const char*>(packed.data()), packed.size()}); }
    Result<void> commit() override { return file_.commit(); }

  private:
    OutputFile file_;
};

void pack_text(const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out) {
    const std::string text = tuple::print_fact(module, module.predicates[table.predicate], id, arguments) + ".\n";
    out.write_bytes(text.data(), text.size());
}

void pack_fact(FactsForm form, const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out) {
    switch (form) {
        case FactsForm::Text:
            return pack_text(module, table, id, arguments, out);
        case FactsForm::Csv:
        case FactsForm::CsvFolder:
            return pack_csv(module, table, id, arguments, out);
        case FactsForm::Hdf5:
            return pack_hdf5(module, table, id, arguments, out);
    }
}

// Calls visit(id, catom) for the catoms of this process, by id. Mostly they have these indices in the same order, and no list is needed.
template <class Visit>
void each_by_id(const sim::Subdomain& subdomain, const Visit& visit) {
    bool ascending = true;
    std::optional<u64> last;
    for (sim::Catom c = 0; ascending && c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const u64 id = subdomain.ensemble.id(c);
        ascending = !last || *last < id;
        last = id;
    }
    if (!ascending) {
        for (const auto& [id, catom] : catoms_by_id(subdomain)) visit(id, catom);
        return;
    }
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) visit(subdomain.ensemble.id(c), c);
}

// Calls visit(id, packed facts) for each catom of this process that has facts of one table, by id; facts go by arguments.
template <class Visit>
void each_packed(sim::Subdomain& subdomain, FactsForm form, const FactTable& table, const Visit& visit) {
    each_by_id(subdomain, [&](u64 id, sim::Catom catom) {
        liveness::beat();
        const std::vector<std::vector<Value>> facts = sorted_facts(subdomain, table.predicate, catom);
        if (facts.empty()) return;
        ByteWriter packed;
        for (const auto& fact : facts) pack_fact(form, subdomain.module, table, id, fact.data(), packed);
        visit(id, packed.view());
    });
}

// All of these: of each catom its id and a block of its packed facts.
std::vector<std::byte> facts_of(sim::Subdomain& subdomain, FactsForm form, const FactTable& table) {
    ByteWriter out;
    each_packed(subdomain, form, table, [&](u64 id, std::span<const std::byte> packed) {
        out.write(id);
        out.write_block(packed);
    });
    return out.take();
}

// What all processes have packed, by id.
void merge(const std::vector<std::vector<std::byte>>& parts, FactsFile& file) {
    std::vector<ByteReader> readers;
    std::priority_queue<std::pair<u64, std::size_t>, std::vector<std::pair<u64, std::size_t>>, std::greater<>> next;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        readers.emplace_back(parts[i], "facts of a process");
        if (!readers[i].done()) next.emplace(readers[i].read<u64>(), i);
    }
    while (!next.empty()) {
        liveness::beat();
        const std::size_t i = next.top().second;
        next.pop();
        file.rows(readers[i].read_block());
        if (!readers[i].done()) next.emplace(readers[i].read<u64>(), i);
    }
}

}  // namespace

FactsForm facts_form(const std::string& path) {
    const std::string extension = std::filesystem::path(path).extension().string();
    return path.ends_with('/')                          ? FactsForm::CsvFolder
           : extension == ".csv"                        ? FactsForm::Csv
           : extension == ".h5" || extension == ".hdf5" ? FactsForm::Hdf5
                                                        : FactsForm::Text;
}

Result<void> check_facts_path(const std::string& path) {
    const FactsForm form = facts_form(path);
    if (form == FactsForm::CsvFolder) return {};
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        return fail(fmt::format("cannot write {}: it is a folder", path),
                    fmt::format("Write {}/ for a CSV file of each predicate in it", path));
    if (form == FactsForm::Hdf5 && OutputFile::names_stream(path))
        return fail(fmt::format("cannot write {}: HDF5 is no stream, and this is no regular file", path), "Choose another path");
    const std::string extension = std::filesystem::path(path).extension().string();
    if (std::ranges::find(kOtherFormats, extension) == kOtherFormats.end()) return {};
    return fail(fmt::format("cannot write {}: facts are not written in the format of {}", path, extension),
                fmt::format("Write {0}.h5, or {0}/ for a folder of CSV files, and convert that; any other name gets text",
                            path.substr(0, path.size() - extension.size())));
}

Result<std::unique_ptr<FactsFile>> open_facts(const std::string& path, const ModuleInfo& module, Durability durability) {
    if (auto fine = check_facts_path(path); !fine) return tl::unexpected(fine.error());
    switch (facts_form(path)) {
        case FactsForm::Csv:
            return open_csv(path, module, durability);
        case FactsForm::CsvFolder:
            return open_csv_folder(path, module, durability);
        case FactsForm::Hdf5:
            return open_hdf5(path, module, durability);
        case FactsForm::Text:
            break;
    }
    auto file = OutputFile::open(path, Appears::Whole, durability);
    if (!file) return tl::unexpected(file.error());
    return std::make_unique<TextFactsFile>(std::move(*file));
}

Result<void> write_facts(sim::Subdomain& subdomain, FactsForm form, FactsFile* file) {
    subdomain.refresh();
    const bool writer = subdomain.comm.process() == 0;
    MELD_CHECK(writer == (file != nullptr), "process 0 alone has the file of facts");
    const std::vector<FactTable> tables = fact_tables(subdomain.module);
    for (const FactTable& table : tables) {
        if (subdomain.alone()) {
            file->begin(table);
            each_packed(subdomain, form, table, [&](u64, std::span<const std::byte> packed) { file->rows(packed); });
            continue;
        }
        std::vector<std::byte> mine = facts_of(subdomain, form, table);
        std::vector<std::vector<std::byte>> all(1);
        if (writer) all[0] = std::move(mine);
        std::vector<comm::Packet> packets;
        if (!writer && !mine.empty()) packets.push_back({0, std::move(mine)});
        for (comm::Packet& p : subdomain.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
        if (!writer) continue;
        file->begin(table);
        merge(all, *file);
    }
    const Result<void> written = writer ? file->commit() : Result<void>{};
    return comm::outcome_of_first(subdomain.comm, written);
}

}  // namespace meld::record
