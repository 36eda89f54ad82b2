# Completion of trammel for fish: the program itself says what can stand at the cursor.
# Read it once:  trammel completion fish | source

function __trammel_complete
    set -l words (commandline -opc)
    set -l typed (commandline -ct)
    set -l lines ($words[1] complete -- $words[2..-1] "$typed" 2>/dev/null)
    set -q lines[1]; or return
    if set -q lines[2]
        string join \n -- $lines[1..-2]
    end
    set -l kept (string replace -r -- '[^=:]*$' '' "$typed")
    set -l piece (string replace -r -- '^.*[=:]' '' "$typed")
    switch $lines[-1]
        case :files
            printf '%s\n' $kept(__fish_complete_path $piece)
        case :folders
            printf '%s\n' $kept(__fish_complete_directories $piece '')
    end
end
complete -c trammel -f -a '(__trammel_complete)'
