#include "runtime/engine/tuple/schema.h"

#include <fmt/format.h>

#include <utility>

#include "runtime/engine/tuple/value_text.h"

namespace meld::tuple {

namespace {

template <class T>
std::vector<T> read_all(ByteReader& in) {
    std::vector<T> all(in.read_count(sizeof(T)));
    for (T& each : all) each = in.read<T>();
    return all;
}

template <class T>
void write_all(const T* from, std::size_t count, ByteWriter& out) {
    out.write_count(count);
    for (std::size_t i = 0; i < count; ++i) out.write(from[i]);
}

}  // namespace

void Schema::save(const ModuleInfo& module, ByteWriter& out) {
    out.write_count(module.type_count);
    for (u32 i = 0; i < module.type_count; ++i) {
        out.write(module.types[i].kind);
        write_all(module.types[i].parts, module.types[i].part_count, out);
    }
    out.write_count(module.predicate_count);
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        out.write_string(p.name);
        out.write(p.kind);
        out.write(p.storage);
        for (const bool flag : {p.auxiliary, p.repeats}) out.write(flag);
        for (const u16 number : {p.column, p.base}) out.write(number);
        for (const u32 number : {p.rank_offset, p.presence_offset, p.presence_mask}) out.write(number);
        out.write_count(p.arity);
        for (u32 f = 0; f < p.arity; ++f) {
            out.write(p.fields[f].type);
            out.write(p.fields[f].bytes);
            out.write(p.fields[f].offset);
            out.write(p.fields[f].deep);
        }
    }
    out.write_count(module.column_count);
    for (u32 i = 0; i < module.column_count; ++i) {
        const ColumnInfo& c = module.columns[i];
        for (const bool flag : {c.rows, c.exported, c.compare_groups != nullptr}) out.write(flag);
        for (const u32 number : {c.stride, c.row_bytes}) out.write(number);
        write_all(c.list_offsets, c.list_count, out);
        write_all(c.list_types, c.list_count, out);
    }
}

bool Schema::read_types(ByteReader& in) {
    types_.resize(in.read_count(sizeof(ValueType)));
    for (std::size_t i = 0; i < types_.size(); ++i) {
        TypeInfo& type = types_[i];
        type.kind = in.read<ValueType>();
        const std::vector<u16>& parts = parts_.emplace_back(read_all<u16>(in));
        type.part_count = static_cast<u16>(parts.size());
        type.parts = parts.data();
        const bool one = type.kind == ValueType::List || type.kind == ValueType::Set || type.kind == ValueType::Array;
        if (type.kind > ValueType::Vec3 || (one && parts.size() != 1)) return false;
        // Parts come before what they are parts of, so nothing is a part of itself.
        for (const u16 part : parts)
            if (part >= i) return false;
    }
    return types_.size() >= kScalarTypes;
}

bool Schema::read_predicates(ByteReader& in) {
    predicates_.resize(in.read_count(sizeof(u32)));
    for (PredicateInfo& p : predicates_) {
        p.name = names_.emplace_back(in.read_string()).c_str();
        p.kind = in.read<PredicateKind>();
        p.storage = in.read<Storage>();
        for (bool* flag : {&p.auxiliary, &p.repeats}) *flag = in.read<bool>();
        for (u16* number : {&p.column, &p.base}) *number = in.read<u16>();
        for (u32* number : {&p.rank_offset, &p.presence_offset, &p.presence_mask}) *number = in.read<u32>();
        std::vector<FieldInfo>& fields = fields_.emplace_back(in.read_count(sizeof(u32)));
        for (FieldInfo& f : fields) {
            f.name = "";
            f.type = in.read<ValueType>();
            f.bytes = in.read<u8>();
            f.offset = in.read<u32>();
            f.deep = in.read<u16>();
            if (f.deep >= types_.size() || types_[f.deep].kind != f.type) return false;
        }
        p.arity = static_cast<u16>(fields.size());
        p.fields = fields.data();
        if (p.kind > PredicateKind::Sensed || p.storage > Storage::World) return false;
    }
    return true;
}

bool Schema::read_columns(ByteReader& in) {
    columns_.resize(in.read_count(sizeof(u32)));
    for (ColumnInfo& c : columns_) {
        c = {};
        c.name = "";
        for (bool* flag : {&c.rows, &c.exported}) *flag = in.read<bool>();
        // What follows the changes of rows is only passed over: their order means nothing here.
        if (in.read<bool>()) c.compare_groups = [](const void*, const void*) { return 0; };
        for (u32* number : {&c.stride, &c.row_bytes}) *number = in.read<u32>();
        const std::vector<u32>& offsets = list_offsets_.emplace_back(read_all<u32>(in));
        const std::vector<u16>& types = list_types_.emplace_back(read_all<u16>(in));
        if (offsets.size() != types.size() || c.stride > (1U << 20) || c.row_bytes > (1U << 20)) return false;
        if (c.rows && (c.stride != kRowsHeadBytes || c.row_bytes == 0)) return false;
        for (std::size_t i = 0; i < offsets.size(); ++i)
            if (offsets[i] + sizeof(u64) > (c.rows ? c.row_bytes : c.stride) || types[i] >= types_.size()) return false;
        c.list_count = static_cast<u32>(offsets.size());
        c.list_offsets = offsets.data();
        c.list_types = types.data();
    }
    return true;
}

// Whether the facts of the predicate lie within its column.
bool Schema::fits(const PredicateInfo& p) const {
    if (p.base != kNone16 && (p.base >= predicates_.size() || predicates_[p.base].arity != p.arity)) return false;
    if (p.column == kNone16) return true;
    if (p.column >= columns_.size()) return false;
    const ColumnInfo& c = columns_[p.column];
    if (c.rows != (p.storage == Storage::Rows)) return false;
    const u64 room = c.rows ? c.row_bytes : c.stride;
    const bool per_link = p.storage == Storage::PerLink;
    for (u32 i = per_link ? 1 : 0; i < p.arity; ++i)
        if (p.fields[i].offset + u64{p.fields[i].bytes} * (per_link ? kMaxPorts : 1) > room) return false;
    if (p.rank_offset != kNone32) return p.rank_offset + u64{kRankBytes} <= room;
    return c.rows || p.presence_offset + u64{per_link ? kPortMaskBytes : kPresenceBytes} <= room;
}

Result<Schema> Schema::read(ByteReader& in) {
    Schema out;
    bool whole = out.read_types(in) && out.read_predicates(in) && out.read_columns(in);
    for (const PredicateInfo& p : out.predicates_) whole = whole && out.fits(p);
    if (in.failed()) return tl::unexpected<Error>(in.outcome().error());
    if (!whole)
        return fail("the snapshot describes facts that cannot be", "It is damaged, or was made by another version",
                    ExitCode::RecordingRefused);
    out.module_ = std::make_unique<ModuleInfo>();
    out.module_->type_count = static_cast<u32>(out.types_.size());
    out.module_->types = out.types_.data();
    out.module_->predicate_count = static_cast<u32>(out.predicates_.size());
    out.module_->predicates = out.predicates_.data();
    out.module_->column_count = static_cast<u32>(out.columns_.size());
    out.module_->columns = out.columns_.data();
    return out;
}

std::string declaration(const ModuleInfo& module, const PredicateInfo& p) {
    const char* const kind = p.kind == PredicateKind::Linear   ? "linear "
                             : p.kind == PredicateKind::Action ? "action "
                             : p.kind == PredicateKind::Sensed ? "sensed "
                                                               : "";
    std::string text = fmt::format("{}{}(node", kind, p.name);
    for (u32 i = 0; i < p.arity; ++i) text += ", " + type_name({module.types, p.fields[i].deep});
    return text + ")";
}

}  // namespace meld::tuple
