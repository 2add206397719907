// Checksums for the pages of SQLite databases.
#pragma once

#include <sqlite3.h>

namespace tessera::server {

/// The name of an SQLite VFS: the machine's files, but each page of a database that has room for it ends with
/// a checksum of the rest and of its number. It is written with the page, and compared whenever the page is
/// read: a page that differs is the error SQLITE_IOERR_DATA. The log (WAL) has checksums of SQLite's own.
/// Registered at the first call; lives as long as the program. Throws std::bad_alloc.
const char* checked_pages_vfs();

/// Makes room for checksums in a database opened with that VFS; one that has pages without is written anew.
/// To be called before the first table is made, outside of transactions. An SQLite result code.
int make_room_for_checksums(sqlite3* database);

}  // namespace tessera::server
