#!/bin/sh
# Runs a compiler (ccache and its arguments). A precompiled header is deleted before it is made anew: GCC reads an
# old one that lies beside the header, and ccache would keep what came of that.
previous=
for argument; do
  case "$previous $argument" in "-o "*.gch) rm -f -- "$argument" ;; esac
  previous=$argument
done
exec "$@"
