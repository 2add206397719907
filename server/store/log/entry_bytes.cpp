#include "store/log/entry_bytes.h"

#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>
#include <variant>

namespace tessera::server {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

// The fields of each kind of entry, in the order of their bytes: new ones are added at the end only, as are
// new kinds of entries to JournalEntry, whose place in the variant is their number.
template <typename Archive>
void fields(Archive& archive, JobAdded& e) {
  archive(e.id, e.request_id, e.spec, e.generation, e.submitted_unix_ms, e.uploaded_bytes);
}
template <typename Archive>
void fields(Archive& archive, JobBound& e) {
  archive(e.id, e.isa);
}
template <typename Archive>
void fields(Archive& archive, JobEnded& e) {
  archive(e.id, e.state, e.error, e.finished_unix_ms);
}
template <typename Archive>
void fields(Archive& archive, UnitDone& e) {
  archive(e.job, e.sequence, e.units.first, e.digest, e.stats, e.host, e.units.ranges);
}
template <typename Archive>
void fields(Archive& archive, JobStats& e) {
  archive(e.id, e.results, e.stats);
}
template <typename Archive>
void fields(Archive& archive, SchedulerEvent& e) {
  archive(e.job, e.kind, e.unit, e.value, e.host, e.text);
}
template <typename Archive>
void fields(Archive& archive, JobReopened& e) {
  archive(e.id);
}
template <typename Archive>
void fields(Archive& archive, JobFetched& e) {
  archive(e.id);
}
template <typename Archive>
void fields(Archive& archive, JobPruned& e) {
  archive(e.id);
}

struct Writer {
  std::string bytes;

  template <typename... Fields>
  void operator()(const Fields&... values) {
    (write(values), ...);
  }
  template <typename Number>
  requires std::is_integral_v<Number>
  void write(Number number) { bytes.append(reinterpret_cast<const char*>(&number), sizeof(number)); }
  void write(const std::string& text) {
    write(static_cast<std::uint32_t>(text.size()));
    bytes += text;
  }
};

struct Reader {
  std::string_view bytes;
  bool sound = true;

  template <typename... Fields>
  void operator()(Fields&... values) {
    (read(values), ...);
  }
  template <typename Number>
  requires std::is_integral_v<Number>
  void read(Number& number) {
    if (bytes.empty()) return;  // written by a version that did not have the field
    sound = sound && bytes.size() >= sizeof(number);
    if (!sound) return;
    std::memcpy(&number, bytes.data(), sizeof(number));
    bytes.remove_prefix(sizeof(number));
  }
  void read(std::string& text) {
    std::uint32_t size = 0;
    read(size);
    sound = sound && bytes.size() >= size;
    if (!sound) return;
    text = bytes.substr(0, size);
    bytes.remove_prefix(size);
  }
};

template <std::size_t kind = 0>
JournalEntry entry_of_kind(std::uint8_t wanted) {
  if constexpr (kind + 1 < std::variant_size_v<JournalEntry>) {
    if (wanted != kind) return entry_of_kind<kind + 1>(wanted);
  }
  return JournalEntry(std::in_place_index<kind>);
}

}  // namespace

std::string entry_bytes(const JournalEntry& entry, const PayloadPlace& payload) {
  Writer writer;
  writer(static_cast<std::uint8_t>(entry.index()), payload.end, payload.bytes, payload.sum);
  // The visitor takes fields by reference to serve both ways; a writer changes none.
  std::visit([&](const auto& e) { fields(writer, const_cast<std::remove_cvref_t<decltype(e)>&>(e)); }, entry);
  return std::move(writer.bytes);
}

std::optional<LoggedEntry> entry_from_bytes(std::string_view bytes) {
  Reader reader{.bytes = bytes};
  auto kind = static_cast<std::uint8_t>(std::variant_size_v<JournalEntry>);
  LoggedEntry logged;
  reader(kind, logged.payload.end, logged.payload.bytes, logged.payload.sum);
  if (!reader.sound || kind >= std::variant_size_v<JournalEntry>) return std::nullopt;
  logged.entry = entry_of_kind(kind);
  std::visit([&](auto& e) { fields(reader, e); }, logged.entry);
  if (!reader.sound) return std::nullopt;
  return logged;
}

const std::string& log_of(const JournalEntry& entry) {
  static const std::string farm;
  return std::visit(
      [](const auto& e) -> const std::string& {
        if constexpr (std::is_same_v<std::remove_cvref_t<decltype(e)>, JobPruned>) {
          return farm;
        } else if constexpr (requires { e.job; }) {
          return e.job;
        } else {
          return e.id;
        }
      },
      entry);
}

}  // namespace tessera::server
