#include "support/scene_file.h"

#include <google/protobuf/text_format.h>

#include <fstream>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "import/import.h"
#include "render/build/load_scene.h"

namespace tessera::test {

namespace {

void resolve(const v1::Scene& scene, v1::JobSpec& job) {
  if (job.width() == 0) job.set_width(scene.film().width());
  if (job.height() == 0) job.set_height(scene.film().height());
  v1::RenderSettings& settings = *job.mutable_settings();
  if (settings.integrator().empty()) settings.set_integrator(scene.settings().integrator());
  if (settings.integrator().empty()) settings.set_integrator("path");
  if (settings.sampler().empty()) settings.set_sampler("sobol");
  if (settings.spp() == 0) settings.set_spp(scene.settings().spp());
  if (!settings.has_max_depth()) {
    settings.set_max_depth(scene.settings().has_max_depth() ? scene.settings().max_depth() : 5);
  }
}

absl::StatusOr<render::BlobBytes> whole_file(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  std::ostringstream out;
  out << in.rdbuf();
  auto bytes = std::make_shared<std::string>(std::move(out).str());
  return render::BlobBytes{*bytes, bytes};
}

}  // namespace

absl::StatusOr<LoadedFile> load_scene_file(const std::string& path, v1::JobSpec job, const std::string& isa,
                                           int threads, const std::function<void(v1::Scene&)>& edit) {
  auto imported = client::import_scene(path);
  if (!imported.ok()) return imported.status();
  if (edit) edit(imported->scene);
  resolve(imported->scene, job);
  std::map<std::string, const client::SceneBlob*> blobs;
  for (const client::SceneBlob& blob : imported->blobs) blobs[blob.ref.digest()] = &blob;
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto it = blobs.find(digest);
    if (it == blobs.end()) return absl::NotFoundError(absl::StrCat("blob ", digest));
    if (!it->second->file.empty()) return whole_file(it->second->file);
    return render::BlobBytes{it->second->bytes, nullptr};
  };
  auto scene = render::load_scene(imported->scene, job, source, {isa, threads});
  if (!scene.ok()) return scene.status();
  return LoadedFile{std::move(job), *std::move(scene)};
}

absl::StatusOr<LoadedFile> load_scene_text(const std::string& text, v1::JobSpec job, const std::string& isa,
                                           const TestBlobs& blobs) {
  v1::Scene scene;
  if (!google::protobuf::TextFormat::ParseFromString(text, &scene)) {
    return absl::InvalidArgumentError("the scene's text does not parse");
  }
  resolve(scene, job);
  const auto source = [&](const std::string& digest) -> absl::StatusOr<render::BlobBytes> {
    const auto it = blobs.find(digest);
    if (it == blobs.end()) return absl::NotFoundError(absl::StrCat("blob ", digest));
    return render::BlobBytes{it->second, nullptr};
  };
  auto loaded = render::load_scene(scene, job, source, {isa, 1});
  if (!loaded.ok()) return loaded.status();
  return LoadedFile{std::move(job), *std::move(loaded)};
}

}  // namespace tessera::test
