// What the importer's fuzz tests feed with bytes: every function takes anything and must return.
#pragma once

#include <string_view>

namespace tessera::fuzz {

/// The PLY reader, with attributes and without; what it accepts must make a sound mesh blob.
void try_ply(std::string_view bytes);

/// The OBJ reader, likewise.
void try_obj(std::string_view bytes);

/// The readers of Mitsuba's serialized meshes and volumes, likewise.
void try_serialized(std::string_view bytes);
void try_volume(std::string_view bytes);

/// The pbrt importer, on a file with these bytes in `folder`; what it accepts must be a sound scene.
void try_pbrt(std::string_view bytes, const char* folder);

/// The Mitsuba importer, likewise.
void try_mitsuba(std::string_view bytes, const char* folder);

/// The reader of scenes in text form, likewise.
void try_text_scene(std::string_view bytes, const char* folder);

/// Whether the importer takes a file with these bytes at `path`, whose ending tells its format.
bool is_accepted(std::string_view bytes, const char* path);

}  // namespace tessera::fuzz
