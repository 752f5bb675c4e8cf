#include "runtime/results/facts/facts_hdf5.h"

#include <fmt/format.h>

#include <deque>
#include <optional>
#include <string_view>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/process/liveness.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/results/hdf5/file_kind.h"
#include "runtime/results/hdf5/hdf5_library.h"

namespace meld::record {

namespace {

constexpr hsize_t kChunkRows = 8192;  // Of some tens of bytes: a few hundred kilobytes, which compress as a whole.

// In memory and in the file a row is packed, without gaps: the catom, then the cells.
std::size_t size_of(CellType type) {
    switch (type) {
        case CellType::Int:
        case CellType::Node:
            return sizeof(std::int64_t);
        case CellType::Float:
            return sizeof(double);
        case CellType::Bool:
            return sizeof(std::int8_t);
        case CellType::Text:
            return sizeof(const char*);
    }
    return 0;
}

// Strings of any length, in UTF-8.
Handle text_type() {
    const hid_t type = H5Tcopy(H5T_C_S1);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return {type, H5Tclose};
}

// As h5py and PyTables know it.
Handle bool_type() {
    const hid_t type = H5Tenum_create(H5T_NATIVE_INT8);
    for (const std::int8_t value : {std::int8_t{0}, std::int8_t{1}}) H5Tenum_insert(type, value == 0 ? "FALSE" : "TRUE", &value);
    return {type, H5Tclose};
}

class Hdf5FactsFile : public FactsFile {
  public:
    Hdf5FactsFile(OutputFile output, std::string path, const ModuleInfo& module)
        : output_(std::move(output)), path_(std::move(path)), module_(module) {}
    ~Hdf5FactsFile() override { close(); }

    void begin(const FactTable& table) override {
        end_table();
        if (file_ < 0) make_file();
        table_ = &table;
        begin_table();
    }
    void rows(std::span<const std::byte> packed) override;
    Result<void> commit() override;

  private:
    void check(std::int64_t result);
    void make_file();
    void begin_table();
    void write_types();
    void write_waiting();
    void end_table();
    void close();

    OutputFile output_;
    std::string path_;
    const ModuleInfo& module_;
    std::optional<Error> failure_;  // The first one; nothing is written after it.
    hid_t file_ = -1;
    // The table that is being written.
    const FactTable* table_ = nullptr;
    hid_t row_type_ = -1, dataset_ = -1;
    hsize_t rows_ = 0, waiting_rows_ = 0;
    std::vector<std::byte> waiting_;
    std::deque<std::string> texts_;  // To which the waiting rows point.
};

void Hdf5FactsFile::check(std::int64_t result) {
    if (result >= 0 || failure_) return;
    const std::string why = text_of_last_error();
    const bool full = why.find("space") != std::string::npos;
    failure_ = Error{fmt::format("cannot write {}: {}", path_, why), full ? "Free some space" : "", ExitCode::LimitHit};
}

void Hdf5FactsFile::make_file() {
    set_up_library_once();
    const auto place = output_.place();
    if (!place) return void(failure_ = place.error());
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    check(H5Pset_obj_track_times(creation, false));
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    check(H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V18));
    file_ = H5Fcreate(place->c_str(), H5F_ACC_TRUNC, creation, access);
    check(file_);
    if (failure_) return;
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle text = text_type();
    const Handle format(H5Acreate2(file_, "format", text, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    const char* const name = kFactsFormat.data();
    check(H5Awrite(format, text, static_cast<const void*>(&name)));
    const Handle version(H5Acreate2(file_, "version", H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(version, H5T_NATIVE_INT64, &kFactsVersion));
}

void Hdf5FactsFile::begin_table() {
    rows_ = 0;
    if (failure_) return;
    std::size_t size = sizeof(std::int64_t);
    for (const TableColumn& column : table_->columns) size += size_of(column.type);
    row_type_ = H5Tcreate(H5T_COMPOUND, size);
    check(H5Tinsert(row_type_, kCatomColumn, 0, H5T_STD_I64LE));
    const Handle text = text_type(), truth = bool_type();
    std::size_t offset = sizeof(std::int64_t);
    for (const TableColumn& column : table_->columns) {
        const hid_t type = column.type == CellType::Text    ? hid_t{text}
                           : column.type == CellType::Bool  ? hid_t{truth}
                           : column.type == CellType::Float ? H5T_IEEE_F64LE
                                                            : H5T_STD_I64LE;
        check(H5Tinsert(row_type_, column.name.c_str(), offset, type));
        offset += size_of(column.type);
    }
    const hsize_t none = 0, any = H5S_UNLIMITED;
    const Handle space(H5Screate_simple(1, &none, &any), H5Sclose);
    const Handle properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_chunk(properties, 1, &kChunkRows));
    check(H5Pset_shuffle(properties));
    check(H5Pset_deflate(properties, 1));
    check(H5Pset_obj_track_times(properties, false));
    dataset_ = H5Dcreate2(file_, table_->name.c_str(), row_type_, space, H5P_DEFAULT, properties, H5P_DEFAULT);
    check(dataset_);
    write_types();
}

// The attribute "types": of each column, how Meld calls its type.
void Hdf5FactsFile::write_types() {
    if (failure_) return;
    std::vector<std::string> names = {"node"};
    for (const TableColumn& column : table_->columns) names.push_back(column_type(module_, *table_, column));
    std::vector<const char*> pointers;
    for (const std::string& name : names) pointers.push_back(name.c_str());
    const hsize_t count = pointers.size();
    const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Handle text = text_type();
    const Handle attribute(H5Acreate2(dataset_, "types", text, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute);
    if (!failure_) check(H5Awrite(attribute, text, static_cast<const void*>(pointers.data())));
}

// Cells are packed as they stand in a row of the file, but for texts, which follow as blocks.
void Hdf5FactsFile::rows(std::span<const std::byte> packed) {
    ByteReader in(packed, "facts of a catom");
    const auto take = [&](const void* from, std::size_t size) {
        const auto* const bytes = static_cast<const std::byte*>(from);
        waiting_.insert(waiting_.end(), bytes, bytes + size);
    };
    while (!in.done()) {
        take(in.read_bytes(sizeof(u64)).data(), sizeof(u64));
        for (const TableColumn& column : table_->columns) {
            if (column.type != CellType::Text) {
                take(in.read_bytes(size_of(column.type)).data(), size_of(column.type));
                continue;
            }
            texts_.push_back(in.read_string());
            const char* const text = texts_.back().c_str();
            take(&text, sizeof text);
        }
        if (++waiting_rows_ == kChunkRows) write_waiting();
    }
}

void Hdf5FactsFile::write_waiting() {
    liveness::beat();
    const hsize_t count = std::exchange(waiting_rows_, 0), end = rows_ + count;
    if (!failure_ && count > 0) {
        check(H5Dset_extent(dataset_, &end));
        const Handle in_file(H5Dget_space(dataset_), H5Sclose);
        check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &rows_, nullptr, &count, nullptr));
        const Handle in_memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
        if (!failure_) check(H5Dwrite(dataset_, row_type_, in_memory, in_file, H5P_DEFAULT, waiting_.data()));
    }
    rows_ = end;
    waiting_.clear();
    texts_.clear();
}

void Hdf5FactsFile::end_table() {
    if (table_ != nullptr) write_waiting();
    table_ = nullptr;
    if (dataset_ >= 0) check(H5Dclose(std::exchange(dataset_, -1)));
    if (row_type_ >= 0) check(H5Tclose(std::exchange(row_type_, -1)));
}

void Hdf5FactsFile::close() {
    end_table();
    if (file_ >= 0) check(H5Fclose(std::exchange(file_, -1)));
}

Result<void> Hdf5FactsFile::commit() {
    if (file_ < 0 && !failure_) make_file();
    close();
    if (failure_) return tl::unexpected(*failure_);
    output_.note_written();
    return output_.commit();
}

}  // namespace

void pack_hdf5(const ModuleInfo& module, const FactTable& table, u64 id, const Value* arguments, ByteWriter& out) {
    const PredicateInfo& p = module.predicates[table.predicate];
    out.write(id);
    for (const TableColumn& column : table.columns) {
        const tuple::Type type = tuple::type_of(module, p.fields[column.argument]);
        const Value value = arguments[column.argument];
        switch (column.type) {
            case CellType::Int:
            case CellType::Node:
                out.write(value);
                break;
            case CellType::Float:
                out.write(type.kind() == ValueType::Vec3 ? tuple::item(value.list, column.item) : value);
                break;
            case CellType::Bool:
                out.write(static_cast<std::int8_t>(value.integer != 0));
                break;
            case CellType::Text:
                out.write_string(tuple::print_plain(type, value));
        }
    }
}

Result<std::unique_ptr<FactsFile>> open_hdf5(const std::string& path, const ModuleInfo& module, Durability durability) {
    auto file = OutputFile::open(path, Appears::Whole, durability);
    if (!file) return tl::unexpected(file.error());
    return std::make_unique<Hdf5FactsFile>(std::move(*file), path, module);
}

}  // namespace meld::record
