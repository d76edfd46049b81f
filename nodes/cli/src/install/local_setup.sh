# Puts fdm_loop on the paths of this shell: . @PREFIX@/share/fdm_loop/local_setup.sh
_fdm_put_first() {
  # $1: name of a list of paths, $2: what it shall hold
  eval "_fdm_list=\${$1:-}"
  case ":$_fdm_list:" in
    *":$2:"*) ;;
    *) eval "export $1=\"\$2\${_fdm_list:+:\$_fdm_list}\"" ;;
  esac
}
_fdm_put_first AMENT_PREFIX_PATH '@PREFIX@'
_fdm_put_first PATH '@PREFIX@/bin'
unset -f _fdm_put_first
unset _fdm_list
