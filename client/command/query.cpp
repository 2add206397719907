// tessera query SCENE: where rays cross its surfaces, what points are in, how its meshes are made.
#include <algorithm>
#include <array>
#include <atomic>
#include <iostream>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "command/command.h"
#include "command/exit_code.h"
#include "command/interrupt.h"
#include "command/query/line_reader.h"
#include "command/query/query_text.h"
#include "command/query/row_text.h"
#include "command/render_options.h"
#include "import/input/diagnostics.h"

namespace tessera::client {
namespace {

struct QueryOptions {
  RenderOptions scene;
  std::vector<Query> option_queries;
  std::string query_file;  // empty: none
  std::optional<QueryKind> kind;
  bool bounds = false, watertight = false;
  RowFormat format = RowFormat::kCsv;
  GeometryOptions geometry;
};

bool print_text(const std::string& text) {
  std::cout.write(text.data(), static_cast<std::streamsize>(text.size())).flush();
  return std::cout.good();
}

/// Queries are answered some thousands at a time, by all threads, and printed in their order.
class Answers {
 public:
  Answers(const GeometryQuery& scene, const QueryOptions& options) : scene_(scene), options_(options) {}

  static constexpr std::size_t kMostWaiting = 8192;
  bool full() const { return waiting_.size() >= kMostWaiting; }
  bool any_waiting() const { return !waiting_.empty(); }
  void add(const Query& query) { waiting_.push_back(query); }
  /// Counts a query that could not be read.
  void skip() { waiting_.emplace_back(); }

  /// False when the answers cannot be written.
  bool flush() {
    constexpr std::size_t kPiece = 256;
    std::vector<std::string> texts((waiting_.size() + kPiece - 1) / kPiece);
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
      for (std::size_t piece = next++; piece < texts.size(); piece = next++) {
        const std::size_t end = std::min(waiting_.size(), (piece + 1) * kPiece);
        answer(piece * kPiece, end, texts[piece]);
      }
    };
    {
      std::vector<std::jthread> helpers;
      const auto wanted = std::min(static_cast<std::size_t>(options_.scene.threads), texts.size());
      for (std::size_t i = 1; i < wanted; ++i) helpers.emplace_back(work);
      work();
    }
    answered_ += static_cast<std::int64_t>(waiting_.size());
    waiting_.clear();
    return std::ranges::all_of(texts, print_text);
  }

 private:
  void answer(std::size_t begin, std::size_t end, std::string& text) const {
    const std::span<const std::optional<Query>> queries(waiting_);
    const std::int64_t number = answered_ + static_cast<std::int64_t>(begin) + 1;
    scene_.answer(queries.subspan(begin, end - begin), number, [&](const Row& row) {
      append_row(GeometryQuery::answer_columns(), row, options_.format, text);
    });
  }

  const GeometryQuery& scene_;
  const QueryOptions& options_;
  std::vector<std::optional<Query>> waiting_;
  std::int64_t answered_ = 0;
};

/// Answers all lines that can be read; others are reported with their places.
int answer_lines(LineReader& reader, const QueryOptions& options, Answers& answers) {
  std::size_t faults = 0;
  std::string_view line;
  for (std::uint32_t number = 1; faults < Diagnostics::kMaxErrors; ++number) {
    if (answers.any_waiting() && (answers.full() || !reader.ready()) && !answers.flush()) return kIncomplete;
    const LineReader::Got got = reader.next(line);
    if (got == LineReader::Got::kEnd) break;
    const ParsedQuery parsed =
        got == LineReader::Got::kLine
            ? parse_query(line, options.kind)
            : ParsedQuery{std::nullopt, absl::StrCat("a line of more than ", kLongestQueryLine, " bytes"), 1};
    if (parsed.query) answers.add(*parsed.query);
    if (parsed.error.empty()) continue;
    ++faults;
    answers.skip();
    report(kUsage, to_string(Diagnostic{reader.name(), number, parsed.column, parsed.error}));
  }
  if (!answers.flush()) return kIncomplete;
  if (reader.failed()) return report(kUsage, absl::StrCat(reader.name(), " cannot be read"));
  return faults > 0 ? kUsage : kDone;
}

int answer_all(const GeometryQuery& scene, const QueryOptions& options) {
  std::string header;
  append_header(GeometryQuery::answer_columns(), options.format, header);
  if (!print_text(header)) return kIncomplete;
  Answers answers(scene, options);
  for (const Query& query : options.option_queries) {
    answers.add(query);
    if (answers.full() && !answers.flush()) return kIncomplete;
  }
  if (options.query_file.empty()) return answers.flush() ? kDone : kIncomplete;
  absl::StatusOr<LineReader> reader = LineReader::open(options.query_file);
  if (!reader.ok()) return report(kUsage, std::string{reader.status().message()});
  return answer_lines(*reader, options, answers);
}

template <class MakeRows>
int print_table(Columns columns, RowFormat format, MakeRows make_rows) {
  std::string text;
  append_header(columns, format, text);
  bool taken = true;
  make_rows([&](const Row& row) {
    append_row(columns, row, format, text);
    if (text.size() < (std::size_t{1} << 20)) return;
    taken = taken && print_text(text);
    text.clear();
  });
  return taken && print_text(text) ? kDone : kIncomplete;
}

int run(QueryOptions& options) {
  const int tables = options.bounds + options.watertight;
  const bool asks = !options.option_queries.empty() || !options.query_file.empty();
  if (tables + asks != 1) {
    return report(kUsage,
                  "give --ray, --inside, --closest or --queries (any of them, as often as you like), or "
                  "--bounds, or --watertight");
  }
  options.scene.job.settings.set_integrator("volpath");  // one that sees media
  int exit_code = kDone;
  const std::unique_ptr<LoadedJob> loaded = load_job(options.scene, exit_code);
  if (loaded == nullptr) return exit_code;
  set_local_isa(loaded->job->spec);
  options.geometry.threads = options.scene.threads;
  const auto scene = GeometryQuery::load(loaded->job->spec, loaded->job->blobs, options.geometry);
  if (!scene.ok()) return report(kBadScene, std::string{scene.status().message()});
  if (!options.scene.quiet) {
    for (const std::string& warning : (*scene)->warnings()) std::cerr << "warning: " << warning << '\n';
    const auto is_closest = [](const Query& query) { return query.kind == QueryKind::kClosest; };
    const std::string doubts = (*scene)->doubts(!options.query_file.empty() ||
                                                std::ranges::any_of(options.option_queries, is_closest));
    if (asks && !doubts.empty()) std::cerr << "warning: " << doubts << '\n';
  }
  if (options.bounds) {
    exit_code = print_table(GeometryQuery::bounds_columns(), options.format,
                            [&](const TakeRow& take) { (*scene)->bounds(take); });
  } else if (options.watertight) {
    exit_code = print_table(GeometryQuery::watertight_columns(), options.format,
                            [&](const TakeRow& take) { (*scene)->watertight(take); });
  } else {
    exit_code = answer_all(**scene, options);
  }
  return exit_code == kIncomplete ? report(kIncomplete, "the answers cannot be written") : exit_code;
}

/// An option whose value is one query.
void add_query(Command& command, const char* name, QueryKind kind, QueryOptions& options,
               const char* description, const char* type) {
  command
      .add_list_read_by(
          name,
          [kind, &options](const std::string& text) -> absl::Status {
            const ParsedQuery parsed = parse_query(text, kind);
            if (!parsed.query) {
              return absl::InvalidArgumentError(parsed.error.empty() ? "there are no numbers" : parsed.error);
            }
            options.option_queries.push_back(*parsed.query);
            return absl::OkStatus();
          },
          [] {}, description)
      .type_name(type);
}

}  // namespace

void add_query_command(CommandLine& line) {
  auto options = std::make_shared<QueryOptions>();
  options->scene.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  Command command = line.add_command(
      "query", "Ask where rays meet a scene, what points are in, and how its meshes are made");
  command.add("SCENE", options->scene.scene, absl::StrCat("the scene: ", kSceneFiles).c_str()).required();
  command.group("Questions");
  add_query(command, "--ray", QueryKind::kRay, *options, "all places where a ray crosses a surface",
            "OX,OY,OZ,DX,DY,DZ");
  add_query(command, "--inside", QueryKind::kInside, *options,
            "the shapes that a point is in, by parity and by winding number, and the medium there", "X,Y,Z");
  add_query(command, "--closest", QueryKind::kClosest, *options, "the closest point of all surfaces",
            "X,Y,Z");
  command
      .add(
          "--queries", options->query_file,
          "a file of them, one a line: 'ray' and six numbers, 'inside' or 'closest' and three; - is standard "
          "input")
      .type_name("FILE");
  command
      .add_read_by(
          "--as",
          [options](const std::string& text) -> absl::Status {
            const auto kind = query_kind(text);
            if (!kind) return absl::InvalidArgumentError("expected ray, inside or closest");
            options->kind = kind;
            return absl::OkStatus();
          },
          "what the lines of --queries are that have numbers alone: ray, inside or closest")
      .type_name("NAME");
  command.add_flag("--bounds", options->bounds, "boxes about the scene, each shape and each instance");
  command.add_flag("--watertight", options->watertight,
                   "defects of meshes and their places: open and crowded edges, triangles that are wound "
                   "against others, without area, or there twice");
  command.group("How");
  command
      .add("--time", options->geometry.shutter_time, "of the shutter, from 0 (it opens) to 1, for what moves")
      .in_range(0, 1)
      .with_default();
  command
      .add_read_by(
          "--origin",
          [options](const std::string& text) -> absl::Status {
            const ParsedQuery point = parse_query(text, QueryKind::kInside);
            if (!point.query) return absl::InvalidArgumentError(point.error);
            options->geometry.origin = std::to_array(point.query->point);
            return absl::OkStatus();
          },
          "coordinates of the scene are rounded to 32 bits about this point; usually where the camera "
          "stands, "
          "as for a picture")
      .type_name("X,Y,Z");
  command.add("-D", options->scene.defines, "a parameter of the scene; may be repeated")
      .type_name("NAME=VALUE");
  command.add("--threads", options->scene.threads, "queries answered at once")
      .in_range(1, 1024)
      .with_default("one a hardware thread");
  command.group("Output");
  command
      .add_read_by(
          "--format",
          [options](const std::string& text) -> absl::Status {
            if (text != "csv" && text != "json") return absl::InvalidArgumentError("expected csv or json");
            options->format = text == "csv" ? RowFormat::kCsv : RowFormat::kJson;
            return absl::OkStatus();
          },
          "csv, or json: an object a line; csv unless given")
      .type_name("NAME");
  command.add_flag("--quiet", options->scene.quiet, "no progress, no warnings");
  command.example("tessera query scenes/cornell-box/scene.pbrt --ray 0,1,5,0,0,-1");
  command.example("tessera query part.textproto --queries points.txt --as inside --format json");
  command.does([options](Interrupt&) { return run(*options); });
}

}  // namespace tessera::client
