#include "import/mitsuba/import_mitsuba.h"

#include "import/input/concat.h"
#include "import/input/finished_scene.h"
#include "import/mitsuba/document/document_reader.h"
#include "import/mitsuba/emitters.h"
#include "import/mitsuba/integrator.h"
#include "import/mitsuba/sensor.h"
#include "import/mitsuba/shapes/shapes.h"

namespace tessera::client::mitsuba {
namespace {

/// Everything below <scene>, in the order of the file.
void write_scene(Context& context) {
  SceneTextures textures(context);
  MaterialTable materials(context, textures);
  MediumTable media(context);
  ShapeWriter shapes(context, textures, materials, media);
  PropertyReader reader(context, *context.document.root);

  const std::vector<Property*> sensors = reader.children("sensor");
  if (sensors.empty()) reader.error("the scene has no sensor");
  if (sensors.size() > 1) {
    context.diagnostics.warning(sensors[1]->where, "the scene has several sensors: only the first is used");
  }
  if (!sensors.empty()) write_sensor(context, media, *std::get<Object*>(sensors.front()->value));
  for (const Property* emitter : reader.children("emitter")) {
    if (context.diagnostics.full()) return;
    write_light(context, textures, *std::get<Object*>(emitter->value));
  }
  for (const Property* shape : reader.children("shape")) {
    if (context.diagnostics.full()) return;
    shapes.write(*std::get<Object*>(shape->value));
  }
  shapes.finish();
  finish_area_lights(context);
  write_integrator(context, reader.child("integrator"));
  // These only count where a shape refers to them.
  for (const char* tag : {"bsdf", "texture", "medium", "phase", "volume"}) reader.children(tag);
}

}  // namespace

absl::StatusOr<ImportedScene> import_mitsuba(const std::filesystem::path& path,
                                             const std::map<std::string, std::string>& defines, int threads) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    return absl::NotFoundError(concat(path.string(), ": no such file"));
  }
  Context context;
  context.threads = threads;
  context.document = read_document(path, defines, context.diagnostics);
  // With errors in the file itself, more could only be consequences.
  if (context.document.root != nullptr && !context.diagnostics.has_errors()) {
    write_scene(context);
    warn_of_unused(context);
  }
  if (absl::Status status = context.diagnostics.status(); !status.ok()) return status;

  ImportedScene imported = finished_scene(std::move(context.scene), path.stem().string(),
                                          std::move(context.blobs), context.diagnostics);
  imported.places = std::move(context.places);
  return imported;
}

}  // namespace tessera::client::mitsuba
