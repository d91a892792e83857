#!/usr/bin/env bash
# For sourcing: run and portable use it to bring the program of preset release up to date. Standard output stays empty.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
build=$root/build/release

say() { printf 'isoextract: %s\n' "$*" >&2; }

# Passes on a build's output, and reports progress on stderr: a line every progress_seconds, also within a long step.
progress_seconds=10
tell_progress() {
  local start=$SECONDS told=$SECONDS begun='' line wait steps=
  while :; do
    wait=$((told + progress_seconds - SECONDS))
    if IFS= read -r -t $((wait > 0 ? wait : 1)) line; then
      printf '%s\n' "$begun$line"
      [[ ! $begun$line =~ ^\[([0-9]+)/([0-9]+)\] ]] || steps="${BASH_REMATCH[1]} of ${BASH_REMATCH[2]} steps, "
      begun=
    elif [ $? -gt 128 ]; then
      begun+=$line
    else
      [ -z "$begun$line" ] || printf '%s\n' "$begun$line"
      return 0
    fi
    if [ $((SECONDS - told)) -ge $progress_seconds ]; then
      told=$SECONDS
      say "build: $steps$((told - start)) s"
    fi
  done
}

# Runs a command. On a terminal, shows its output; elsewhere, reports progress, and shows the output only on failure.
quietly() {
  if [ -t 2 ]; then
    "$@" >&2
  else
    "$@" 2>&1 | tell_progress >"$build/build.log"
    [ "${PIPESTATUS[0]}" -eq 0 ] || {
      tail -n 60 "$build/build.log" >&2
      return 1
    }
  fi
}

# Builds the program and the plug-ins with the given IDs ("vtk", "dicom"), which are package groups of setup.sh as well.
bring_up_to_date() {
  local missing=()
  for group in "$@"; do
    compgen -G "$build/plugins/isoextract-*-$group.so" >/dev/null || missing+=("$group")
  done
  if [ -f "$build/build.ninja" ] && [ ${#missing[@]} -eq 0 ]; then
    case $(ninja -C "$build" -n isoextract "${@/#/plugins_}" 2>/dev/null) in
      *"no work to do"*) return ;;
    esac
  fi
  "$root/scripts/setup.sh" build "${missing[@]}" || return
  cd "$root" || return
  say "building the program in build/release; the first time takes some minutes"
  quietly cmake --preset release || return
  quietly cmake --build --preset release --target isoextract completions "${@/#/plugins_}"
}

# Installs missing packages, and builds the program and the named plug-ins; ends the script with 3 if that fails.
build_release() {
  mkdir -p "$build"
  # The lock serializes builds that start at once; it ends with the subshell.
  if ! (flock 9 && bring_up_to_date "$@") 9>"$build/.lock"; then
    say "the program could not be built"
    exit 3
  fi
}
