#include "light_field/manifest.h"

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "wire/digest.h"

namespace tessera::light_field {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char kFormat[] = "tessera light field";
constexpr std::pair<Compression, const char*> kWords[] = {
    {Compression::kNone, "none"}, {Compression::kZip, "zip"}, {Compression::kDwaa, "dwaa"}};

Json json_of(const Imath::V3d& v) { return Json::array({v.x, v.y, v.z}); }

Imath::V3d point_of(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

absl::Status fault(const std::string& what) { return absl::InvalidArgumentError(what); }

Json json_of(const CameraGrid& grid) {
  return {{"name", grid.name},
          {"first_view", grid.first_view},
          {"columns", grid.columns},
          {"rows", grid.rows},
          {"spacing", {grid.spacing_x, grid.spacing_y}},
          {"world_from_grid", grid.world_from_grid},
          {"focus", grid.focus}};
}

CameraGrid grid_of(const Json& json) {
  CameraGrid grid;
  grid.name = json.at("name").get<std::string>();
  grid.first_view = json.at("first_view").get<std::uint32_t>();
  grid.columns = json.at("columns").get<std::uint32_t>();
  grid.rows = json.at("rows").get<std::uint32_t>();
  grid.spacing_x = json.at("spacing").at(0).get<double>();
  grid.spacing_y = json.at("spacing").at(1).get<double>();
  grid.world_from_grid = json.at("world_from_grid").get<Matrix4>();
  grid.focus = json.at("focus").get<double>();
  return grid;
}

Json json_of(const Arrangement& arrangement) {
  Json json = {{"kind", arrangement.kind}, {"target", json_of(arrangement.target)}};
  if (arrangement.kind == "sphere") json["radius"] = arrangement.radius;
  if (arrangement.kind == "box")
    json["box"] = Json::array({json_of(arrangement.box_low), json_of(arrangement.box_high)});
  json["grids"] = Json::array();
  for (const CameraGrid& grid : arrangement.grids) json["grids"].push_back(json_of(grid));
  return json;
}

Arrangement arrangement_of(const Json& json) {
  Arrangement arrangement;
  arrangement.kind = json.at("kind").get<std::string>();
  arrangement.target = point_of(json.at("target"));
  arrangement.radius = json.value("radius", 0.0);
  if (json.contains("box")) {
    arrangement.box_low = point_of(json.at("box").at(0));
    arrangement.box_high = point_of(json.at("box").at(1));
  }
  for (const Json& grid : json.at("grids")) arrangement.grids.push_back(grid_of(grid));
  return arrangement;
}

Json json_of(const Provenance& provenance) {
  return {{"program", provenance.program},
          {"scene", provenance.scene},
          {"scene_digest", provenance.scene_digest},
          {"integrator", provenance.integrator},
          {"seed", provenance.seed},
          {"samples_per_pixel", provenance.samples_per_pixel},
          {"settings", provenance.settings},
          {"defines", provenance.defines}};
}

Provenance provenance_of(const Json& json) {
  Provenance provenance;
  provenance.program = json.value("program", "");
  provenance.scene = json.value("scene", "");
  provenance.scene_digest = json.value("scene_digest", "");
  provenance.integrator = json.value("integrator", "");
  provenance.seed = json.value("seed", std::uint64_t{0});
  provenance.samples_per_pixel = json.value("samples_per_pixel", 0u);
  provenance.settings = json.value("settings", "");
  provenance.defines = json.value("defines", std::vector<std::string>{});
  return provenance;
}

Json json_of(const View& view) {
  const Pinhole& camera = view.camera;
  Json tiles = Json::array();
  for (const Tile& tile : view.tiles)
    tiles.push_back(Json::array({tile.offset, tile.bytes, hash_text(tile.hash)}));
  return {{"name", view.name},
          {"world_from_camera", camera.world_from_camera},
          {"intrinsics", {camera.fx, camera.fy, camera.cx, camera.cy}},
          {"file", view.file},
          {"bytes", view.file_bytes},
          {"tiles", std::move(tiles)}};
}

absl::StatusOr<View> view_of(const Json& json) {
  View view;
  view.name = json.at("name").get<std::string>();
  view.camera.world_from_camera = json.at("world_from_camera").get<Matrix4>();
  const auto intrinsics = json.at("intrinsics").get<std::array<double, 4>>();
  view.camera.fx = intrinsics[0], view.camera.fy = intrinsics[1];
  view.camera.cx = intrinsics[2], view.camera.cy = intrinsics[3];
  view.file = json.at("file").get<std::string>();
  view.file_bytes = json.at("bytes").get<std::uint64_t>();
  if (!wire::is_digest(view.file)) return fault("its file has no name of 64 hexadecimal digits");
  const bool sound = std::isfinite(1 / view.camera.fx) && std::isfinite(1 / view.camera.fy) &&
                     std::isfinite(view.camera.cx) && std::isfinite(view.camera.cy);
  if (!sound) return fault("its intrinsics are those of no camera");
  if (!inverse(view.camera.world_from_camera)) return fault("its world_from_camera has no inverse");
  for (const Json& entry : json.at("tiles")) {
    Tile& tile = view.tiles.emplace_back();
    tile.offset = entry.at(0).get<std::uint64_t>();
    tile.bytes = entry.at(1).get<std::uint64_t>();
    const auto hash = entry.at(2).get<std::string>();
    if (hash.size() != 16 || !absl::SimpleHexAtoi(hash, &tile.hash))
      return fault(absl::StrCat("tile ", view.tiles.size() - 1, ": '", hash, "' is no hash of 16 digits"));
    if (tile.offset > view.file_bytes || tile.bytes > view.file_bytes - tile.offset)
      return fault(absl::StrCat("tile ", view.tiles.size() - 1, " ends behind its file"));
  }
  return view;
}

absl::Status check_grid(const CameraGrid& grid, std::size_t views) {
  const std::uint64_t cameras = std::uint64_t{grid.columns} * grid.rows;
  if (cameras == 0 || grid.first_view + cameras > views) {
    return fault(absl::StrCat("grid '", grid.name, "' has ", grid.columns, " x ", grid.rows,
                              " cameras from view ", grid.first_view, " on, and there are ", views,
                              " views"));
  }
  const bool spaced = (grid.columns == 1 || grid.spacing_x > 0) && (grid.rows == 1 || grid.spacing_y > 0);
  if (!spaced || !(grid.focus > 0) || !inverse(grid.world_from_grid))
    return fault(absl::StrCat("grid '", grid.name, "': its spacing, focus and axes make no grid"));
  return absl::OkStatus();
}

absl::StatusOr<Manifest> parse(const Json& json) {
  if (json.value("format", "") != kFormat)
    return fault(absl::StrCat("it is no light field: its format is not '", kFormat, "'"));
  if (const int version = json.at("version").get<int>(); version != kVersion) {
    return fault(
        absl::StrCat("it is of version ", version, " of the format; this program reads version ", kVersion));
  }
  Manifest manifest;
  manifest.width = json.at("width").get<std::uint32_t>();
  manifest.height = json.at("height").get<std::uint32_t>();
  manifest.tile_size = json.at("tile_size").get<std::uint32_t>();
  const auto in_range = [](std::uint32_t side) { return side > 0 && side <= kMostSide; };
  if (!in_range(manifest.width) || !in_range(manifest.height) || !in_range(manifest.tile_size) ||
      !std::has_single_bit(manifest.tile_size)) {
    return fault(absl::StrCat("views of ", manifest.width, "x", manifest.height, " pixels in tiles of ",
                              manifest.tile_size, ": sides go up to ", kMostSide,
                              ", and those of tiles are powers of two"));
  }
  const auto word = json.at("compression").get<std::string>();
  const auto* const known = std::ranges::find(kWords, word, [](const auto& row) { return row.second; });
  if (known == std::end(kWords)) return fault(absl::StrCat("there is no compression '", word, "'"));
  manifest.compression = known->first;
  manifest.half = json.at("half").get<bool>();
  manifest.dwa_level = json.value("dwa_level", 0.0);
  manifest.psnr_db = json.value("psnr_db", 0.0);
  manifest.metres = json.value("metres", 0.0);
  manifest.colour_space = json.value("colour_space", manifest.colour_space);
  manifest.provenance = provenance_of(json.value("provenance", Json::object()));
  const Json& views = json.at("views");
  if (views.empty() || views.size() > kMostViews)
    return fault(absl::StrCat("it has ", views.size(), " views; 1 to ", kMostViews, " are possible"));
  const std::size_t tiles = std::size_t{manifest.tile_columns()} * manifest.tile_rows();
  for (const Json& entry : views) {
    const std::string name = absl::StrCat("view ", manifest.views.size(), ": ");
    absl::StatusOr<View> view = view_of(entry);
    if (!view.ok()) return fault(absl::StrCat(name, view.status().message()));
    if (view->tiles.size() != tiles)
      return fault(absl::StrCat(name, "it has ", view->tiles.size(), " tiles, and its size has ", tiles));
    manifest.views.push_back(*std::move(view));
  }
  manifest.arrangement = arrangement_of(json.at("arrangement"));
  for (const CameraGrid& grid : manifest.arrangement.grids) {
    if (absl::Status s = check_grid(grid, manifest.views.size()); !s.ok()) return s;
  }
  return manifest;
}

}  // namespace

const char* word_of(Compression compression) {
  return std::ranges::find(kWords, compression, [](const auto& row) { return row.first; })->second;
}

std::uint64_t tile_hash(std::string_view bytes) {
  std::uint64_t hash = 0;
  static_cast<void>(absl::SimpleHexAtoi(wire::sha256_hex(bytes).substr(0, 16), &hash));
  return hash;
}

std::string hash_text(std::uint64_t hash) { return absl::StrCat(absl::Hex(hash, absl::kZeroPad16)); }

std::string to_json(const Manifest& manifest) {
  const char* const colour = manifest.half ? "half" : "float";
  Json channels = Json::array();
  for (const char* const name : {"A", "B", "G", "R"})
    channels.push_back(Json{{"name", name}, {"type", colour}});
  channels.push_back(Json{{"name", "depth.Z"}, {"type", "float"}});
  Json json = {{"format", kFormat},
               {"version", kVersion},
               {"width", manifest.width},
               {"height", manifest.height},
               {"tile_size", manifest.tile_size},
               {"half", manifest.half},
               {"channels", std::move(channels)},
               {"compression", word_of(manifest.compression)}};
  if (manifest.compression == Compression::kDwaa) {
    json["dwa_level"] = manifest.dwa_level;
    if (manifest.psnr_db > 0) json["psnr_db"] = manifest.psnr_db;
  }
  json["colour_space"] = manifest.colour_space;
  if (manifest.metres > 0) json["metres"] = manifest.metres;
  json["provenance"] = json_of(manifest.provenance);
  json["arrangement"] = json_of(manifest.arrangement);
  // A view a line: sets have hundreds.
  std::string text = json.dump(1);
  text.resize(text.size() - 2);  // "\n}"
  text += ",\n \"views\": [";
  for (std::size_t v = 0; v < manifest.views.size(); ++v)
    absl::StrAppend(&text, v > 0 ? ",\n  " : "\n  ", json_of(manifest.views[v]).dump());
  return text + "\n ]\n}\n";
}

absl::StatusOr<Manifest> manifest_from_json(std::string_view text) {
  try {
    return parse(Json::parse(text));
  } catch (const std::exception& error) {  // what is missing, or of another type, and where
    return fault(error.what());
  }
}

absl::StatusOr<Manifest> read_manifest(const std::string& folder) {
  const std::string path = (std::filesystem::path(folder) / kManifestFile).string();
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("there is no light field at ", folder, ": no ", path));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  absl::StatusOr<Manifest> manifest = manifest_from_json(text);
  if (manifest.ok()) return manifest;
  return absl::InvalidArgumentError(absl::StrCat(path, ": ", manifest.status().message()));
}

std::string data_file(const std::string& folder, const View& view) {
  return (std::filesystem::path(folder) / kDataFolder / (view.file + ".exr")).string();
}

}  // namespace tessera::light_field
