#include "import/pbrt/import_pbrt.h"

#include "import/input/finished_scene.h"
#include "import/pbrt/file/directive_reader.h"

namespace tessera::client::pbrt {

absl::StatusOr<ImportedScene> import_pbrt(const std::filesystem::path& path, int threads) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return absl::NotFoundError(path.string() + ": no such file");
  }
  Context context;
  context.directory = path.parent_path();
  context.threads = threads;
  {
    DirectiveHandler builder(context);
    DirectiveReader reader(context, builder);
    reader.read_file(path, SourceLocation{});
    if (!context.diagnostics.full()) builder.finish();
  }  // whose parameters say at their end what nobody asked for
  if (absl::Status status = context.diagnostics.status(); !status.ok()) return status;

  std::filesystem::path name = path.filename();
  if (name.extension() == ".gz") name = name.stem();
  ImportedScene imported = finished_scene(std::move(context.scene), name.stem().string(),
                                          std::move(context.blobs), context.diagnostics);
  imported.places = std::move(context.places);
  return imported;
}

}  // namespace tessera::client::pbrt
